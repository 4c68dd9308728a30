"""ggx.py: rough surfaces of GGX microfacets: reflection with a diffuse ground, and transmission into a dense medium."""

import numpy as np

from gonio.dataset.scattering import Features, FloatArray, IndexArray
from gonio.model.analytic import fresnel
from gonio.model.analytic.family import Parameter, Process
from gonio.model.analytic.polar_rule import integral_about

NARROW = 0.2  # roughness below which the lobe is a peak for integrators
DIFFUSE = Parameter("diffuse", "1", 0.0, 1.0, False, "hemispherical value of the Lambertian ground")
ROUGHNESS = Parameter("alpha", "1", 0.003, 1.0, True, "roughness: width of the facets' slopes")


def distribution(cosine: FloatArray, alpha: FloatArray | float) -> FloatArray:
    """D [1/sr] of facet normals at `cosine` from the surface's: Walter et al. 2007 eq. 33, cos^4 (alpha^2 + tan^2)^2
    written without tan."""
    a2 = np.asarray(alpha) ** 2
    return np.asarray(a2 / (np.pi * (1.0 + (a2 - 1.0) * np.asarray(cosine) ** 2) ** 2))


def visible(cosine: FloatArray, alpha: FloatArray | float) -> FloatArray:
    """Smith's G1 towards a direction at `cosine` from the normal: Walter et al. 2007 eq. 34."""
    c = np.maximum(np.asarray(cosine), 1e-12)
    return np.asarray(2.0 / (1.0 + np.sqrt(1.0 + np.asarray(alpha) ** 2 * (1.0 - c**2) / c**2)))


def facet_reflection(incident: FloatArray, outgoing: FloatArray, alpha: FloatArray) -> tuple[FloatArray, FloatArray]:
    """BRDF [1/sr] (m,) without Fresnel's factor, G = G1 G1, and the cosine (m,) at the facet: eq. 20, 23."""
    half = incident + outgoing
    length = np.maximum(np.linalg.norm(half, axis=1), 1e-300)
    at_facet = np.clip(length / 2.0, 0.0, 1.0)  # i . h = |i + o| / 2
    ci, co = np.maximum(incident[:, 2], 1e-12), np.maximum(outgoing[:, 2], 1e-12)
    d = distribution(half[:, 2] / length, alpha)
    return visible(ci, alpha) * visible(co, alpha) * d / (4.0 * ci * co), at_facet


class _Reflection:
    """What both kinds of Fresnel factor share: BRDF = diffuse / pi + F G D / (4 cos cos)."""

    processes: tuple[Process, ...] = ("reflection",)
    per_direction = False

    def _fresnel(self, cosine: FloatArray, of_surface: FloatArray) -> FloatArray:
        raise NotImplementedError

    def bsdf_per_sr(
        self, values: FloatArray, incident: FloatArray, outgoing: FloatArray, which: IndexArray
    ) -> FloatArray:
        """See Family."""
        of = values[which]
        facet, cosine = facet_reflection(incident[which], outgoing, of[:, 1])
        return np.asarray(of[:, 0] / np.pi + self._fresnel(cosine, of[:, 2]) * facet)

    def integral(self, values: FloatArray, incident: FloatArray) -> FloatArray:
        """See Family; to about 1e-5 up to 85 degrees (polar_rule.peak_rule)."""
        return integral_about(self.bsdf_per_sr, values, incident, -np.hypot(incident[:, 0], incident[:, 1]))

    def features(self, values: FloatArray, incident: FloatArray) -> Features:
        """The mirror direction, where the surface is smooth: facets turn by alpha / sqrt 2, light by twice that in the
        plane of incidence and by 2 cos(theta_i) of it across."""
        rows = np.flatnonzero(values[:, 1] < NARROW)
        sigma = np.sqrt(2.0) * values[rows, 1] * np.maximum(incident[rows, 2], 0.1)
        return Features(incident[rows] * np.array([-1.0, -1.0, 1.0]), sigma, rows.astype(np.int64))


class GGX(_Reflection):
    """BRDF = diffuse / pi + F G D / (4 cos cos): Walter et al. 2007 eq. 20 with D eq. 33, G = G1 G1 eq. 23 and 34, and
    Schlick's F. At most diffuse + 1; G1 G1 loses what facets scatter twice."""

    name = "ggx"
    source = "Walter, Marschner, Li, Torrance 2007 eq. 20, 23, 33, 34; Schlick 1994 eq. 15"
    parameters = (
        DIFFUSE,
        ROUGHNESS,
        Parameter("f0", "1", 1e-4, 1.0, True, "Fresnel reflectance at normal incidence"),
    )

    def _fresnel(self, cosine: FloatArray, of_surface: FloatArray) -> FloatArray:
        return fresnel.schlick(cosine, of_surface)

    def starts(self, mirror_bsdf: float, far_bsdf: float) -> FloatArray:
        """See Family."""
        found = []
        for alpha in (0.02, 0.08, 0.25, 0.6):
            top = 1.0 / (4.0 * np.pi * alpha**2)  # at normal incidence, F = 1
            found.append((min(np.pi * far_bsdf, 0.98), alpha, float(np.clip(mirror_bsdf / top, 1e-3, 0.99))))
        return np.array(found)


class GGXDielectric(_Reflection):
    """GGX with the exact Fresnel factor of a dielectric of relative index `index`: Walter et al. 2007 eq. 22."""

    name = "ggx-dielectric"
    source = "Walter, Marschner, Li, Torrance 2007 eq. 20, 22, 23, 33, 34"
    parameters = (
        DIFFUSE,
        ROUGHNESS,
        Parameter("index", "1", 1.01, 4.0, True, "refractive index of the sample over that of air"),
    )

    def _fresnel(self, cosine: FloatArray, of_surface: FloatArray) -> FloatArray:
        return fresnel.dielectric(cosine, of_surface)

    def starts(self, mirror_bsdf: float, far_bsdf: float) -> FloatArray:
        """See Family."""
        del mirror_bsdf
        return np.array([(min(np.pi * far_bsdf, 0.9), alpha, 1.5) for alpha in (0.02, 0.08, 0.25, 0.6)])


class GGXThrough:
    """BTDF = diffuse / pi + transmission through one rough interface into a medium of index `index`, in which the
    outgoing directions lie: Walter et al. 2007 eq. 16 and 21. Reciprocal up to index^2, as radiance in a medium is. A
    plate in air has two interfaces; fitted to it, `index` is an effective value: how far facets turn light."""

    name = "ggx-through"
    source = "Walter, Marschner, Li, Torrance 2007 eq. 16, 21, 22, 23, 33, 34"
    processes: tuple[Process, ...] = ("transmission",)
    parameters = (
        DIFFUSE,
        ROUGHNESS,
        Parameter("index", "1", 1.01, 4.0, True, "refractive index on the leaving side over that on the light's side"),
    )
    per_direction = False

    def bsdf_per_sr(
        self, values: FloatArray, incident: FloatArray, outgoing: FloatArray, which: IndexArray
    ) -> FloatArray:
        """See Family."""
        diffuse, alpha, index = values[which].T
        i = incident[which]
        o = outgoing * np.array([1.0, 1.0, -1.0])  # unfolded: it leaves on the other side
        half = i + index[:, None] * o
        length = np.maximum(np.linalg.norm(half, axis=1), 1e-300)
        half = half / length[:, None]
        half *= np.where(half[:, 2] < 0.0, -1.0, 1.0)[:, None]
        ih, oh = np.einsum("ij,ij->i", i, half), np.einsum("ij,ij->i", o, half)
        there = (ih > 0.0) & (oh < 0.0)  # both on the sides of the facet on which light arrives and leaves
        ci, co = np.maximum(i[:, 2], 1e-12), np.maximum(-o[:, 2], 1e-12)
        let_in = 1.0 - fresnel.dielectric(np.clip(ih, 0.0, 1.0), index)
        shape = visible(ci, alpha) * visible(co, alpha) * distribution(half[:, 2], alpha)
        jacobian = index**2 * np.abs(ih * oh) / (ci * co * length**2)
        return np.asarray(diffuse / np.pi + np.where(there, let_in * shape * jacobian, 0.0))

    def integral(self, values: FloatArray, incident: FloatArray) -> FloatArray:
        """See Family; to about 1e-5 up to 85 degrees. Beyond the rim no facet lets light through: at it the facet's
        normal lies in the surface, and as GGX has such facets the BTDF ends with a step."""
        centre = np.hypot(incident[:, 0], incident[:, 1]) / values[:, 2]
        rim = np.sqrt(1.0 - (incident[:, 2] / values[:, 2]) ** 2)
        facets = values * np.array([0.0, 1.0, 1.0])
        return values[:, 0] + integral_about(self.bsdf_per_sr, facets, incident, -centre, rim)

    def features(self, values: FloatArray, incident: FloatArray) -> Features:
        """The refracted direction (Snell), where the surface is smooth; facets turn light by (index - 1) / index."""
        beta = -incident[:, :2] / values[:, 2:3]
        z2 = 1.0 - np.sum(beta**2, axis=1)
        rows = np.flatnonzero((values[:, 1] < NARROW) & (z2 > 0.0))
        centre = np.concatenate((beta[rows], np.sqrt(z2[rows])[:, None]), axis=1)
        turned = np.maximum(np.abs(1.0 - 1.0 / values[rows, 2]), 0.02)
        sigma = values[rows, 1] / np.sqrt(2.0) * turned * np.maximum(incident[rows, 2], 0.1)
        return Features(centre, sigma, rows.astype(np.int64))

    def starts(self, mirror_bsdf: float, far_bsdf: float) -> FloatArray:
        """See Family."""
        del mirror_bsdf
        ground = min(np.pi * far_bsdf, 0.9)
        return np.array([(ground, alpha, index) for alpha in (0.05, 0.2, 0.6) for index in (1.1, 1.5)])
