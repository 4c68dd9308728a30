"""setting.py: a scenario ready to be read, be its sample traced or a closed form."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from gonio.dataset.bsdf import Polarisation
from gonio.simulate.bundle import INSTRUMENT, Bundle, pack, read_document
from gonio.simulate.closed_form import Truth
from gonio.simulate.closed_form_run import read_closed_form
from gonio.simulate.progress import PhotonProgress
from gonio.simulate.readings import Job, Reading
from gonio.simulate.request import Request
from gonio.units.errors import UsageError
from gonio.units.instrument import load_instrument

if TYPE_CHECKING:
    from gonio.simulate.campaign import Crew, Effort
    from gonio.simulate.tracing import Laboratory

_STEP_DEG = 1.0
_CLOSED_FORM_KEYS = {  # of the scenario's top level and of two of its tables; the others are the running twin's
    "": {"seed", "instrument", "sample", "beam", "detector", "timing", "drives", "fault", "readings", "band"},
    "sample": {"components", "mounted"},
    "readings": {"incident", "step_deg"},
}
_MOST_TIMES = 1000  # the photons of the scenario, where it names no end


class Setting(Protocol):
    """What the readings of a scenario come from."""

    bands: list[tuple[str, float | None]]  # name, wavelength in nm
    incidents: list[tuple[float, float]]
    step_deg: float
    provenance: dict[str, Any]
    estimator: tuple[str, int]  # of the sample's jobs, with its bandwidth
    polarisation: Polarisation  # of the light that arrives

    @property
    def relative_error(self) -> float:
        """That the median reading should have; 0: whatever comes."""

    def read(self, jobs: Sequence[Job], photons: int | None = None) -> list[Reading]:
        """One reading per job, with as many photons as the scenario wants, or with exactly `photons`."""


@dataclass
class ClosedFormSetting:
    """Nothing is traced: the readings are exact."""

    truth: Truth
    bands: list[tuple[str, float | None]]
    incidents: list[tuple[float, float]]
    step_deg: float
    provenance: dict[str, Any]
    estimator: tuple[str, int] = ("fixed", 0)
    polarisation: Polarisation = "unpolarised"

    @property
    def relative_error(self) -> float:
        """See Setting."""
        return 0.0

    def read(self, jobs: Sequence[Job], photons: int | None = None) -> list[Reading]:  # noqa: ARG002 - none are needed
        """See Setting."""
        return read_closed_form(self.truth, jobs)


@dataclass
class PhotonSetting:
    """Readings are traced by a crew."""

    bands: list[tuple[str, float | None]]
    incidents: list[tuple[float, float]]
    step_deg: float
    provenance: dict[str, Any]
    effort: "Effort"
    crew: "Crew"
    progress: PhotonProgress
    half_angle_rad: float
    estimator: tuple[str, int]
    laboratory: "Laboratory"
    polarisation: Polarisation

    @property
    def relative_error(self) -> float:
        """See Setting."""
        return self.effort.relative_error

    def read(self, jobs: Sequence[Job], photons: int | None = None) -> list[Reading]:
        """See Setting."""
        from gonio.simulate.campaign import Effort, run  # noqa: PLC0415 - needs the compiled module

        effort = self.effort if photons is None else Effort(photons)
        return run(jobs, effort, self.half_angle_rad, self.crew, self.progress)


@contextmanager
def open_setting(request: Request, progress: PhotonProgress) -> Iterator[Setting]:
    """The scenario of a request, ready; workers that were started for it end with it. Raises UsageError."""
    document = read_document(request.scenario)
    sample = document.get("sample")
    if isinstance(sample, dict) and "kind" in sample:
        with _photon_setting(request, document, progress) as setting:
            yield setting
        return
    _check_keys(request.scenario, document)
    for option, value in (("--photons", request.photons), ("--error", request.relative_error)):
        if value is not None:
            raise UsageError(
                f"{option}: the sample of {request.scenario} is a closed form, without photons: leave it out"
            )
    yield _closed_form_setting(request.scenario, document)


def _closed_form_setting(path: Path, document: dict[str, Any]) -> ClosedFormSetting:
    truth = Truth.from_scenario(path)
    readings = document.get("readings", {})
    incidents = readings.get("incident", [[0.0, 0.0]])
    step_deg = readings.get("step_deg", _STEP_DEG)
    pairs = isinstance(incidents, list) and all(_is_direction(pair) for pair in incidents)
    if not pairs or not incidents:
        raise UsageError(f"{path}: readings.incident must be a list of [theta 0 to 180, phi 0 to 360] in degrees")
    if not _is_number(step_deg) or not 0.1 <= step_deg <= 30.0:
        raise UsageError(f"{path}: readings.step_deg must be a number from 0.1 to 30")
    bands = document.get("band", [{}])
    if not isinstance(bands, list) or not bands or not all(isinstance(band, dict) for band in bands):
        raise UsageError(f"{path}: band must be a list of tables: write [[band]]")
    return ClosedFormSetting(
        truth=truth,
        bands=[(str(band.get("name", "visible")), band.get("wavelength_nm")) for band in bands],
        incidents=[(float(theta), float(phi)) for theta, phi in incidents],
        step_deg=float(step_deg),
        provenance={
            **_files(pack(path, None, ())),
            "instrument_text": truth.scenario.instrument.text,
            "estimator": {"kind": "closed form, averaged over beam and aperture"},
        },
    )


def _check_keys(path: Path, document: dict[str, Any]) -> None:
    """UsageError for what no closed form has, and where there is no sample at all."""
    tables = {"": document, "sample": document.get("sample", {}), "readings": document.get("readings", {})}
    for name, table in tables.items():
        if not isinstance(table, dict):
            raise UsageError(f"{path}: {name} must be a table: write [{name}]")
        unknown = sorted(table.keys() - _CLOSED_FORM_KEYS[name])
        if unknown:
            place = f"{name}.{unknown[0]}" if name else unknown[0]
            raise UsageError(f"{path}: {place} is not a key of a closed form: remove it or correct its spelling")
    if not tables["sample"].get("components"):
        raise UsageError(f"{path}: no sample: give [sample] a kind (traced) or components (closed form)")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_direction(pair: Any) -> bool:
    good = isinstance(pair, list) and len(pair) == 2 and all(_is_number(angle) for angle in pair)
    return good and 0.0 <= pair[0] <= 180.0 and 0.0 <= pair[1] <= 360.0


@contextmanager
def _photon_setting(request: Request, document: dict[str, Any], progress: PhotonProgress) -> Iterator[PhotonSetting]:
    try:
        from gonio.simulate.campaign import Effort  # noqa: PLC0415 - needs the compiled module
        from gonio.simulate.tracing import Laboratory, embree_version  # noqa: PLC0415
    except ImportError as missing:
        raise UsageError(f"the photon map is not built ({missing}): run make build") from missing
    bundle = pack(request.scenario, request.seed, _band_names(document))
    laboratory = Laboratory(bundle, request.scenario)
    scenario = laboratory.scenario(_band_names(document)[0])
    bands: list[tuple[str, float | None]] = list(scenario.bands)
    error = scenario.relative_error if request.relative_error is None else request.relative_error
    bandwidth = scenario.bandwidth if scenario.estimator == "nearest" else 0
    if scenario.estimator != "fixed" and error > 0.0:
        raise UsageError(f"{request.scenario}: photons until an error is reached need estimator = fixed")
    photons = scenario.photons if request.photons is None else request.photons
    most = max(photons, scenario.most_photons or _MOST_TIMES * photons)
    half_angle_rad = laboratory.half_angle_rad(bands[0][0])
    instrument = load_instrument(_instrument(request.scenario, document))
    with _crew(request, bundle, laboratory, progress) as crew:
        yield PhotonSetting(
            bands=bands,
            incidents=scenario.incidents,
            step_deg=scenario.direction_step_deg,
            provenance={
                **_files(bundle),
                "instrument_text": instrument.text,
                "seed": scenario.seed,
                "estimator": {
                    "kind": scenario.estimator,
                    "bandwidth": bandwidth,
                    "aperture_half_angle_rad": half_angle_rad,
                    "acceptance_deg": scenario.acceptance_deg,
                    "relative_error": error,
                    "photons": photons,
                    "most_photons": most,
                },
                "walk": {band: laboratory.scenario(band).walk(band) for band, _ in bands},
                "embree": embree_version(),
            },
            effort=Effort(photons, error, most),
            crew=crew,
            progress=progress,
            half_angle_rad=half_angle_rad,
            estimator=(scenario.estimator, bandwidth),
            laboratory=laboratory,
            polarisation=_polarisation(document),
        )


def _polarisation(document: dict[str, Any]) -> Polarisation:
    """Of the lamp; s is across the plane of incidence of a sample that turns about the vertical."""
    source = document.get("source", {})
    if "stokes" in source:
        return "unknown"
    if "polarisation_deg" not in source:
        return "unpolarised"
    named: dict[float, Polarisation] = {0.0: "s", 90.0: "p"}
    return named.get(float(source["polarisation_deg"]) % 180.0, "unknown")


@contextmanager
def _crew(request: Request, bundle: Bundle, laboratory: "Laboratory", progress: PhotonProgress) -> Iterator["Crew"]:
    if request.scheduler is None and request.workers == 0:
        from gonio.simulate.tracing import LocalCrew  # noqa: PLC0415 - needs the compiled module

        yield LocalCrew(laboratory, request.threads, progress)
        return
    from gonio.simulate.cluster import ClusterCrew, connected  # noqa: PLC0415 - Dask only where it is asked for

    with connected(request.scheduler, request.workers) as client:
        yield ClusterCrew(client, bundle)


def _instrument(path: Path, document: dict[str, Any]) -> Path | None:
    """The instrument file as the photon map finds it: the one named, else axes.toml beside the scenario."""
    file = path.parent / str(document.get("instrument", INSTRUMENT))
    return file if "instrument" in document or file.exists() else None


def _band_names(document: dict[str, Any]) -> tuple[str, ...]:
    bands = document.get("band")
    named = [band.get("name") for band in bands if isinstance(band, dict)] if isinstance(bands, list) else []
    return tuple(str(name) for name in named) or ("visible",)


def _files(bundle: Bundle) -> dict[str, Any]:
    return {"scenario": bundle.scenario, "scenario_text": bundle.text, "files_sha256": bundle.hashes()}
