"""style.py: the report's style sheet: one column on a phone, two on a desk, black on white in print."""

CSS = """
:root{--ink:#1c2733;--muted:#5d6975;--line:#dfe3e8;--soft:#f5f7f9;--accent:#00538a;--warn:#9a3b0e}
*{box-sizing:border-box}
html{scroll-behavior:smooth;-webkit-text-size-adjust:100%}
body{margin:0 auto;max-width:68rem;padding:1.5rem 1.25rem 4rem;font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,
 "Helvetica Neue",Arial,sans-serif;color:var(--ink);background:#fff}
h1{font-size:1.7rem;line-height:1.2;margin:.2rem 0 .3rem}
h2{font-size:1.2rem;margin:2.6rem 0 .7rem;padding-top:.9rem;border-top:1px solid var(--line)}
h3{font-size:1rem;margin:1.6rem 0 .4rem}
p{max-width:54rem;margin:.5rem 0}
.lead,.note,figcaption{color:var(--muted)}
.note,figcaption{font-size:.86rem}
.eyebrow{color:var(--accent);font-size:.8rem;font-weight:600;letter-spacing:.06em;text-transform:uppercase}
nav{margin:1rem 0 0;display:flex;flex-wrap:wrap;gap:.25rem 1.1rem;font-size:.9rem}
a{color:var(--accent);text-decoration:none}a:hover{text-decoration:underline}
.facts{display:grid;grid-template-columns:repeat(auto-fit,minmax(9.5rem,1fr));gap:.6rem;margin:1.3rem 0}
.facts div{background:var(--soft);border-radius:6px;padding:.6rem .8rem}
.facts dt{font-size:.78rem;color:var(--muted)}
.facts dd{margin:0;font-size:1.12rem;font-weight:600;overflow-wrap:anywhere}
.scroll{overflow-x:auto;margin:.7rem 0}
table{border-collapse:collapse;font-size:.88rem;font-variant-numeric:tabular-nums;min-width:100%}
th,td{text-align:right;padding:.34rem .7rem;border-bottom:1px solid var(--line);white-space:nowrap}
th{white-space:normal;font-weight:600;color:var(--muted);border-bottom:1.5px solid var(--muted);vertical-align:bottom}
th:first-child,td:first-child,.text,.name{text-align:left}
tr.strong td{font-weight:600}
.wide td:first-child{white-space:normal;min-width:13rem}
td.text{white-space:normal;overflow-wrap:anywhere;min-width:14rem}
figure{margin:.8rem 0 1.4rem}img{max-width:100%;height:auto;display:block}
details{border:1px solid var(--line);border-radius:6px;padding:.2rem .9rem;margin:.6rem 0}
summary{cursor:pointer;padding:.4rem 0;font-weight:600}
.warn{border-left:3px solid var(--warn);padding:.1rem .9rem;color:var(--warn)}
.lobe{max-width:46rem;margin:0 auto}.lobe canvas{width:100%;display:block;cursor:grab;touch-action:pan-y}
.lobe-bar{display:flex;flex-wrap:wrap;gap:.35rem;align-items:center;font-size:.86rem}
.lobe-bar button{font:inherit;padding:.15rem .6rem;border:1px solid var(--line);border-radius:5px;
 background:var(--soft);color:var(--ink);cursor:pointer}
.lobe-bar output{color:var(--muted);font-variant-numeric:tabular-nums;min-height:1.4em}
ul.remarks{padding-left:1.1rem;max-width:56rem}
footer{margin-top:3rem;color:var(--muted);font-size:.82rem;border-top:1px solid var(--line);padding-top:.8rem}
@media(max-width:640px){figure{overflow-x:auto}figure img{max-width:46rem}}
@media print{body{max-width:none;padding:0;font-size:10.5pt}nav{display:none}
 figure,table,.facts{break-inside:avoid}h2,h3{break-after:avoid}details{border:none;padding:0}.lobe-bar{display:none}.scroll{overflow:visible}
 td,th{padding:.2rem .4rem}}
"""
