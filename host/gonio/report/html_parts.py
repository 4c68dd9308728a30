"""html_parts.py: small pieces of HTML: everything that comes from data is escaped here."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np


def number(value: float | None, digits: int = 4) -> str:
    """A figure for a table: significant digits, an en dash where there is none."""
    if value is None or not np.isfinite(value):
        return "\u2013"
    return f"{value:.{digits}g}"


def fixed(value: float | None, decimals: int) -> str:
    """A figure with a fixed number of decimals, an en dash where there is none."""
    return "\u2013" if value is None or not np.isfinite(value) else f"{value:.{decimals}f}"


def percent(value: float | None, decimals: int = 1) -> str:
    return "\u2013" if value is None or not np.isfinite(value) else f"{100 * value:.{decimals}f} %"


def signed_percent(value: float | None, decimals: int = 3) -> str:
    if value is None or not np.isfinite(value):
        return "\u2013"
    return f"{round(100 * value, decimals) + 0.0:+.{decimals}f} %"  # no negative zero


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    text_columns: Sequence[int] = (),
    name_columns: Sequence[int] = (),
    strong_rows: Sequence[int] = (),
    wide: bool = False,
) -> str:
    """Cells are escaped; columns in `text_columns` may wrap and are set left, those in `name_columns`
    are set left; rows in `strong_rows` are set strong; of
    a `wide` table the first column may wrap."""

    def cells(tag: str, row: Sequence[str]) -> str:
        kinds = {**dict.fromkeys(name_columns, " class=name"), **dict.fromkeys(text_columns, " class=text")}
        return "".join(f"<{tag}{kinds.get(i, '')}>{escape(cell)}</{tag}>" for i, cell in enumerate(row))

    body = "".join(
        f"<tr{' class=strong' if i in strong_rows else ''}>{cells('td', row)}</tr>" for i, row in enumerate(rows)
    )
    kind = "scroll wide" if wide else "scroll"
    return f'<div class="{kind}"><table><thead><tr>{cells("th", head)}</tr></thead><tbody>{body}</tbody></table></div>'


def subtitle(text: str) -> str:
    return f"<h3>{escape(text)}</h3>"


def facts(items: Mapping[str, str]) -> str:
    inner = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in items.items())
    return f'<dl class="facts">{inner}</dl>'


def figure(uri: str, alt: str, caption: str) -> str:
    return (
        f'<figure><img src="{uri}" alt="{escape(alt, quote=True)}"><figcaption>{escape(caption)}</figcaption></figure>'
    )


def section(identifier: str, title: str, *parts: str) -> str:
    return f'<section id="{identifier}"><h2>{escape(title)}</h2>{"".join(parts)}</section>'


def paragraph(text: str, kind: str = "") -> str:
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def bullets(lines: Iterable[str]) -> str:
    return '<ul class="remarks">' + "".join(f"<li>{escape(line)}</li>" for line in lines) + "</ul>"


def folded(title: str, *parts: str, opened: bool = False) -> str:
    return f"<details{' open' if opened else ''}><summary>{escape(title)}</summary>{''.join(parts)}</details>"


def flatten(value: Any, name: str = "") -> list[tuple[str, str]]:
    """Nested plain values as (dotted name, text); long texts are cut, their end is in the dataset."""
    if isinstance(value, Mapping):
        return [pair for key, item in value.items() for pair in flatten(item, f"{name}.{key}" if name else str(key))]
    if isinstance(value, list | tuple):
        if all(not isinstance(item, Mapping | list | tuple) for item in value):
            return [(name, _short(", ".join(str(item) for item in value)))]
        return [pair for i, item in enumerate(value) for pair in flatten(item, f"{name}[{i}]")]
    return [(name, _short(str(value)))]


def _short(text: str) -> str:
    return text if len(text) <= 300 else text[:297] + "..."
