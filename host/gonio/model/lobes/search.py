"""search.py: from strong to weak: look for what stands out, fit it with its neighbours, keep it if it pays."""

import numpy as np
from numpy.typing import NDArray

from gonio.model.lobes.found import BROADEST_RAD, Found
from gonio.model.lobes.gauss import Gauss
from gonio.model.lobes.judge import as_good, misfit, pays, sound, stands_out
from gonio.model.lobes.starts import Standing, Start, guess, starts_at, starts_near, starts_of

FloatArray = NDArray[np.float64]

MOST_TRIES = 20
STARTS_IN_VAIN = 4  # in a row, of narrow and of broad things each: what follows is weaker still
CLOSE_CONTRAST = 0.2  # of the highest: starts that one look serves; weaker ones wait until the strong are taken off
FEW_PITCHES = 1.2  # standard deviation in distances of points below which too few see a lobe to tell its shape
ELONGATED = 1.3  # ratio of standard deviations from which a lobe may be two side by side
MISFIT = 0.03  # mean relative error about a lobe above which it is no Gaussian


class Search:
    """Looks for lobes of one distribution and leaves them in `found`."""

    def __init__(self, found: Found, most: int) -> None:
        self.found = found
        self.most = most
        self.given_up: list[Start] = []
        self.tries = 0
        self.in_vain = [0, 0]  # of narrow, of broad starts

    def run(self, hints: tuple[FloatArray, ...]) -> None:
        """All looks, then all lobes once more with what was found since."""
        standing = self._look_everywhere()
        self._take(starts_at(self.found, standing, hints, self.given_up))
        self._look_again()
        if self._look_closely():
            self._look_again()
        self._merge_pieces()
        if self.found.polish() > 0.002:
            self.found.polish()
        self._drop_faded()

    def _merge_pieces(self) -> None:
        """Puts one lobe in the place of two of like size side by side, where it does as well: pieces of one are what
        is left when a fit was led astray by a stronger neighbour not yet known."""
        for lobe in sorted(self.found.lobes, key=lambda g: g.peak):
            place = next((k for k, g in enumerate(self.found.lobes) if g is lobe), None)
            near = [] if place is None else self.found.neighbours(lobe, but=place)
            other = next((k for k in near if _may_be_one(lobe, self.found.lobes[k])), None)
            if place is None or other is None:
                continue
            rest = [k for k in near if k != other]
            whole = _merged(lobe, self.found.lobes[other])
            pieces = [lobe, self.found.lobes[other], *(self.found.lobes[k] for k in rest)]
            view = self.found.view(pieces, [place, other, *rest])
            if view is None:
                continue
            fit = view.fit([whole, *pieces[2:]], 25)
            if as_good(view, fit, view.fit(pieces, 10)) and sound(view, fit, 1):
                self.found.accept(tuple(view.true(g) for g in fit.lobes), rest, 1)
                for k in sorted((place, other), reverse=True):
                    self.found.drop(k)

    def _drop_faded(self) -> None:
        """Forgets lobes that their neighbours, found later, have left next to nothing of, or that have spread."""
        while self._drop_weakest():
            self.found.polish()

    def _drop_weakest(self) -> bool:
        """Of faded lobes side by side only the weakest: without it the others may be worth something. Whether any."""
        spared: list[Gauss] = []
        known = len(self.found.lobes)
        for lobe in sorted(self.found.lobes, key=lambda g: g.peak):
            place = next(k for k, g in enumerate(self.found.lobes) if g is lobe)
            if not any(g is lobe for g in spared) and self._has_faded(place):
                spared += [self.found.lobes[k] for k in self.found.neighbours(lobe, but=place)]
                self.found.drop(place)
        return len(self.found.lobes) < known

    def _has_faded(self, place: int) -> bool:
        lobe = self.found.lobes[place]
        if float(lobe.sigma[1]) > 0.99 * BROADEST_RAD:
            return True
        own = [place, *self.found.neighbours(lobe, but=place)]
        if len(own) == 1:
            return False
        lobes = [self.found.lobes[k] for k in own]
        view = self.found.view(lobes, own)
        return view is not None and not stands_out(view, view.fit(lobes, 1), 0)

    def _going_on(self) -> bool:
        return len(self.found.lobes) < self.most and self.tries < MOST_TRIES

    def _look_everywhere(self) -> Standing:
        """Over the whole hemisphere until nothing more is found; what then stands above all that is known."""
        standing, known = Standing(self.found), 0
        while True:
            if len(self.found.lobes) > known:
                standing, known = Standing(self.found), len(self.found.lobes)
            starts = [s for s in starts_of(self.found, standing, self.given_up) if self._worth(s)]
            if not starts or not self._going_on():
                return standing
            self._take([s for s in starts if s.contrast >= CLOSE_CONTRAST * starts[0].contrast])

    def _look_closely(self) -> bool:
        """About narrow lobes in dense data; whether anything was found."""
        known = len(self.found.lobes)
        place = 0
        while place < len(self.found.lobes) and self._going_on():
            self.in_vain = [0, 0]
            self._take(starts_near(self.found, self.found.lobes[place], self.given_up))
            place += 1
        return len(self.found.lobes) > known

    def _class_of(self, start: Start) -> int:
        return int(start.sigma > 3.0 * self.found.scene.cell_rad)

    def _worth(self, start: Start) -> bool:
        return self.in_vain[self._class_of(start)] < STARTS_IN_VAIN

    def _take(self, starts: list[Start]) -> None:
        known = len(self.found.lobes)
        for start in starts:
            if not self._going_on():
                return
            if not self._worth(start) or any(_touches(start, lobe) for lobe in self.found.lobes[known:]):
                continue  # what was seen there was partly the lobe; the next look tells what is left
            first = guess(self.found, start)
            if first is not None and self._try_shapes(first):
                self.in_vain[self._class_of(start)] = 0
            else:
                self.in_vain[self._class_of(start)] += 1
                self.given_up.append(start)

    def _try_shapes(self, first: Gauss) -> bool:
        """An elliptic lobe; where the points are too few for one, a circular one."""
        own = self.found.neighbours(first)
        if self._try([first], own):
            return True
        few = float(first.sigma[0]) < FEW_PITCHES * self.found.scene.finest_near(first.centre)
        return few and self._try([first.rounded()], own)

    def _try(self, new: list[Gauss], own: list[int], replaced: int | None = None) -> bool:
        """Fits new lobes with accepted ones; keeps them if each is sound and all together pay.

        own: accepted lobes that are fitted along; replaced: one that the new ones stand for.
        """
        self.tries += 1
        taken = own if replaced is None else [*own, replaced]
        lobes = [*new, *(self.found.lobes[k] for k in own)]
        view = self.found.view(lobes, taken)
        if view is None:
            return False
        fit = view.fit(lobes, 25)
        if not sound(view, fit, len(new)) or not pays(view, fit, len(new), [self.found.lobes[k] for k in taken]):
            return False
        self.found.accept(tuple(view.true(g) for g in fit.lobes), own, len(new))
        if replaced is not None:
            self.found.drop(replaced)
        return True

    def _look_again(self) -> None:
        """Peaks that are no Gaussians: a wider or a narrower lobe about the same centre, or two side by side."""
        place = 0
        while place < len(self.found.lobes) and self._going_on():
            lobe = self.found.lobes[place]
            if misfit(self.found, place) > MISFIT and (
                self._try([_scaled(lobe, 2.5, 0.1)], [place])
                or self._try([_scaled(lobe, 0.5, 0.3)], [place])
                or (float(lobe.sigma[1] / lobe.sigma[0]) > ELONGATED and self._try(_halves(lobe), [], place))
            ):
                continue
            place += 1


def _touches(start: Start, lobe: Gauss) -> bool:
    away = float(np.arccos(np.clip(start.centre @ lobe.centre, -1.0, 1.0)))
    return away < 3.0 * start.sigma + 2.0 * float(lobe.sigma[1])


def _scaled(lobe: Gauss, width: float, height: float) -> Gauss:
    return Gauss.of(lobe.centre, lobe.covariance * width**2, lobe.peak * height, frame=lobe.frame)


def _halves(lobe: Gauss) -> list[Gauss]:
    """Two lobes along the longer axis that together have about the same second moment."""
    values, axes = np.linalg.eigh(lobe.covariance)
    offset = 0.75 * np.sqrt(values[1]) * axes[:, 1]
    covariance = axes @ np.diag([values[0], 0.4 * values[1]]) @ axes.T
    half = Gauss.of(lobe.centre, covariance, 0.8 * lobe.peak, frame=lobe.frame)
    return [half.shifted(-offset), half.shifted(offset)]


def _may_be_one(a: Gauss, b: Gauss) -> bool:
    size = float(np.sqrt(np.prod(a.sigma) / np.prod(b.sigma)))
    away = min(float(g.whitened(o.centre[None, :])[1][0]) for g, o in ((a, b), (b, a)))
    return 0.5 < size < 2.0 and away < 2.0**2


def _merged(a: Gauss, b: Gauss) -> Gauss:
    """One lobe with the moments that both have together, in the frame of the first."""
    local = a.frame @ b.centre
    across = float(np.hypot(local[0], local[1]))
    offset = local[:2] * (float(np.arctan2(across, local[2])) / max(across, 1e-300))
    power_a, power_b = a.lobe().power, b.lobe().power
    share = power_b / (power_a + power_b)
    turn = a.frame[:2] @ b.frame[:2].T
    covariance = (1.0 - share) * a.covariance + share * turn @ b.covariance @ turn.T
    covariance = covariance + share * (1.0 - share) * np.outer(offset, offset)
    peak = (power_a + power_b) / (2.0 * np.pi * float(np.sqrt(np.linalg.det(covariance))))
    return Gauss.of(a.centre, covariance, peak, frame=a.frame).shifted(share * offset)
