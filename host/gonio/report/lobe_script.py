"""lobe_script.py: the script that draws and turns the lobes: a small rasteriser with a depth buffer on a plain canvas.

It needs neither a library nor the graphics card, so any number of lobes stays alive on a page and prints as it stands.
Coordinates: the sample's x, y, z; the view turns about z by yaw and is tilted by pitch, both in degrees.
"""

SCRIPT = r"""
(function(){'use strict';
var COLOURS='@COLOURS@',table=new Uint8Array(768);
for(var i=0;i<768;i++)table[i]=parseInt(COLOURS.substr(2*i,2),16);
function unpack(text,Type){var s=atob(text),n=s.length,b=new Uint8Array(n);
 for(var i=0;i<n;i++)b[i]=s.charCodeAt(i);return new Type(b.buffer);}
function deg(a){return a*Math.PI/180;}
function along(theta,phi,r){var s=Math.sin(deg(theta));
 return[r*s*Math.cos(deg(phi)),r*s*Math.sin(deg(phi)),r*Math.cos(deg(theta))];}
function lobe(box){
 var canvas=box.querySelector('canvas'),say=box.querySelector('output'),told=JSON.parse(canvas.dataset.told);
 var p=unpack(canvas.dataset.places,Int16Array),dir=unpack(canvas.dataset.directions,Int16Array);
 var f=unpack(canvas.dataset.facets,Uint16Array),n=p.length/3,m=f.length/3;
 var yaw=-60,pitch=22,zoom=1,W=0,H=0,depth,owner,picture,context=canvas.getContext('2d'),X=new Float32Array(n),
  Y=new Float32Array(n),Z=new Float32Array(n),level=new Float32Array(n),waiting=false,unit=1,shown=0;
 for(var i=0;i<n;i++)level[i]=Math.min(1,Math.hypot(p[3*i],p[3*i+1],p[3*i+2])/32767);
 function view(){var a=deg(yaw),b=deg(pitch),whole=told.transmission,mid=H*(whole?0.5:0.8);
  var s=zoom*Math.min(W/2.9,H/(whole?2.6:1.75));
  var ca=Math.cos(a),sa=Math.sin(a),cb=Math.cos(b),sb=Math.sin(b);
  return function(x,y,z){var u=-sa*x+ca*y,v=ca*x+sa*y;
   return[W/2+s*u,mid-s*(cb*z-sb*v),cb*v+sb*z];};}
 function size(){var ratio=Math.min(window.devicePixelRatio||1,2),w=canvas.clientWidth||640,h=Math.round(w*0.66);
  canvas.style.height=h+'px';W=Math.round(w*ratio);H=Math.round(h*ratio);canvas.width=W;canvas.height=H;unit=Math.max(W/640,ratio);
  depth=new Float32Array(W*H);owner=new Int32Array(W*H);picture=context.createImageData(W,H);}
 function facet(k){var a=f[3*k],b=f[3*k+1],c=f[3*k+2],x0=X[a],y0=Y[a],x1=X[b],y1=Y[b],x2=X[c],y2=Y[c];
  var area=(x1-x0)*(y2-y0)-(x2-x0)*(y1-y0);if(Math.abs(area)<1e-9)return;
  var e1x=p[3*b]-p[3*a],e1y=p[3*b+1]-p[3*a+1],e1z=p[3*b+2]-p[3*a+2],
   e2x=p[3*c]-p[3*a],e2y=p[3*c+1]-p[3*a+1],e2z=p[3*c+2]-p[3*a+2];
  var nx=e1y*e2z-e1z*e2y,ny=e1z*e2x-e1x*e2z,nz=e1x*e2y-e1y*e2x,len=Math.hypot(nx,ny,nz)||1;
  var light=0.62+0.38*Math.abs((nx*lamp[0]+ny*lamp[1]+nz*lamp[2])/len);
  var t=Math.round(255*(level[a]+level[b]+level[c])/3)*3;
  var r=table[t]*light,g=table[t+1]*light,bl=table[t+2]*light,d=picture.data;
  var left=Math.max(0,Math.floor(Math.min(x0,x1,x2))),right=Math.min(W-1,Math.ceil(Math.max(x0,x1,x2)));
  var top=Math.max(0,Math.floor(Math.min(y0,y1,y2))),low=Math.min(H-1,Math.ceil(Math.max(y0,y1,y2)));
  for(var y=top;y<=low;y++)for(var x=left;x<=right;x++){
   var w1=((x-x0)*(y2-y0)-(x2-x0)*(y-y0))/area,w2=((x1-x0)*(y-y0)-(x-x0)*(y1-y0))/area;
   if(w1<-1e-4||w2<-1e-4||w1+w2>1.0001)continue;
   var z=Z[a]+w1*(Z[b]-Z[a])+w2*(Z[c]-Z[a]),q=y*W+x;
   if(z<=depth[q])continue;depth[q]=z;owner[q]=k+1;
   d[4*q]=r;d[4*q+1]=g;d[4*q+2]=bl;d[4*q+3]=255;}}
 var lamp=[0,0,1];
 function line(points,colour,width,dash){
  context.strokeStyle=colour;context.lineWidth=width*unit;context.setLineDash(dash?[5*unit,4*unit]:[]);
  var pen=false;context.beginPath();
  points.forEach(function(s){var x=Math.round(s[0]),y=Math.round(s[1]);
   var hidden=x>=0&&y>=0&&x<W&&y<H&&depth[y*W+x]>s[2]+0.015;
   if(hidden)pen=false;else if(pen)context.lineTo(s[0],s[1]);else{context.moveTo(s[0],s[1]);pen=true;}});
  context.stroke();}
 function words(text,s,colour){var x=Math.round(s[0]),y=Math.round(s[1]);
  if(x>=0&&y>=0&&x<W&&y<H&&depth[y*W+x]>s[2]+0.015)return;
  context.font=Math.round(12*unit)+'px system-ui,sans-serif';context.fillStyle=colour;
  context.strokeStyle='rgba(255,255,255,.85)';context.lineWidth=3*unit;context.setLineDash([]);
  context.strokeText(text,s[0]+4*unit,s[1]-4*unit);context.fillText(text,s[0]+4*unit,s[1]-4*unit);}
 function straight(a,b,to){var r=[];for(var i=0;i<=60;i++){var t=i/60;
  r.push(to(a[0]+t*(b[0]-a[0]),a[1]+t*(b[1]-a[1]),a[2]+t*(b[2]-a[2])));}return r;}
 function draw(){waiting=false;if(!W)return;
  var to=view(),i,a=deg(yaw),b=deg(pitch);
  lamp=[Math.cos(b)*Math.cos(a+0.5),Math.cos(b)*Math.sin(a+0.5),Math.sin(b+0.4)];
  depth.fill(-1e9);owner.fill(0);picture.data.fill(0);
  for(i=0;i<n;i++){var s=to(p[3*i]/32767,p[3*i+1]/32767,p[3*i+2]/32767);X[i]=s[0];Y[i]=s[1];Z[i]=s[2];}
  for(i=0;i<m;i++)facet(i);
  context.setTransform(1,0,0,1,0,0);context.clearRect(0,0,W,H);context.putImageData(picture,0,0);
  var span=told.top-told.floor,phi=told.incident[1],first=Math.ceil(told.floor+0.05),step=span>5?2:1;
  for(var decade=first;decade<=told.top;decade++){if((decade-first)%step)continue;
   var r=(decade-told.floor)/span,arc=[],end=told.transmission?360:180,ring=[];
   for(i=0;i<=end;i+=3)arc.push(to.apply(null,along(i-90,phi,r)));
   line(arc,'rgba(70,80,92,.75)',0.7,true);
   for(i=0;i<=360;i+=4)ring.push(to.apply(null,along(90,i,r)));
   line(ring,'rgba(70,80,92,.35)',0.6);
   words('10'+String(decade).replace(/[-0-9]/g,function(c){return'\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079'
    .charAt(c==='-'?0:+c+1);}),to.apply(null,along(90,phi+180,r)),'#46505c');}
  line(straight([0,0,told.transmission?-1.12:0],[0,0,1.12],to),'#46505c',0.8);
  words('front normal',to(0,0,1.12),'#46505c');
  var source=along(told.incident[0],phi,1.2);
  line(straight(source,[0,0,0],to),'#c8541b',2);words('source',to.apply(null,source),'#c8541b');
  var mirror=along(told.incident[0],phi+180,1.12);
  line(straight(mirror,[0,0,0],to),'#c8541b',0.9,true);
  if(told.incident[0]>3)words('mirror',to.apply(null,mirror),'#c8541b');
  if(told.transmission)line(straight(along(180-told.incident[0],phi+180,1.12),[0,0,0],to),'#c8541b',0.9,true);}
 function later(){if(!waiting){waiting=true;window.requestAnimationFrame(draw);}}
 function turn(dx,dy){yaw-=dx;pitch=Math.max(-89,Math.min(89,pitch+dy));later();}
 function tell(event){var r=canvas.getBoundingClientRect(),x=Math.round((event.clientX-r.left)*W/r.width),
   y=Math.round((event.clientY-r.top)*H/r.height),k=owner&&x>=0&&y>=0&&x<W&&y<H?owner[y*W+x]:0;
  if(!k){say.textContent='';return;}
  var best=f[3*k-3],least=1e9;for(var j=0;j<3;j++){var v=f[3*k-3+j],e=Math.hypot(X[v]-x,Y[v]-y);
   if(e<least){least=e;best=v;}}
  var c=[dir[3*best],dir[3*best+1],dir[3*best+2]],len=Math.hypot(c[0],c[1],c[2]);
  var theta=Math.acos(c[2]/len)*180/Math.PI,phi=(Math.atan2(c[1],c[0])*180/Math.PI+360)%360;
  var value=Math.pow(10,told.floor+level[best]*(told.top-told.floor));
  say.textContent='\u03b8 '+theta.toFixed(1)+'\u00b0, \u03c6 '+phi.toFixed(1)+'\u00b0: DSF '+
   (level[best]>0?value.toPrecision(3):'under '+Math.pow(10,told.floor).toPrecision(1))+' 1/sr';}
 var last=null;
 canvas.addEventListener('pointerdown',function(e){last=[e.clientX,e.clientY];canvas.setPointerCapture(e.pointerId);});
 canvas.addEventListener('pointermove',function(e){if(!last){tell(e);return;}
  turn((e.clientX-last[0])*0.5,(e.clientY-last[1])*0.5);last=[e.clientX,e.clientY];});
 ['pointerup','pointercancel'].forEach(function(kind){canvas.addEventListener(kind,function(){last=null;});});
 canvas.addEventListener('keydown',function(e){
  var by={ArrowLeft:[-6,0],ArrowRight:[6,0],ArrowUp:[0,-6],ArrowDown:[0,6]}[e.key];
  if(by){turn(by[0],by[1]);e.preventDefault();}});
 box.querySelectorAll('button').forEach(function(button){button.addEventListener('click',function(){
  if(button.dataset.view){var v=button.dataset.view.split(',');yaw=+v[0]+told.incident[1];pitch=+v[1];zoom=1;}
  else zoom=Math.max(0.5,Math.min(8,zoom*button.dataset.zoom));later();});});
 yaw=-60+told.incident[1];
 // Drawn at once: a printer or a picture of the page does not wait for the next frame.
 function fit(){var w=canvas.clientWidth;if(w&&w!==shown){shown=w;size();draw();}}
 if(window.ResizeObserver)new ResizeObserver(fit).observe(box);
 window.addEventListener('beforeprint',fit);fit();}
document.querySelectorAll('.lobe').forEach(lobe);
})();
"""


def script(colours: str) -> str:
    """The script element; `colours`: see lobe.colour_table."""
    return f"<script>{SCRIPT.replace('@COLOURS@', colours)}</script>"
