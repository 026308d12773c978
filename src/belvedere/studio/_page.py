"""The report's page: one HTML file from its numbers and pictures. All text is escaped here."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from belvedere.studio._chart import Line, legend, psnr_chart
from belvedere.studio._meaning import meaning
from belvedere.studio._page_frame import PageFrame, framed_page
from belvedere.studio._pictures import PictureCollector, ViewPictures
from belvedere.studio.scores import COLUMNS, shown_number


def render_page(report: Mapping[str, Any], pictures: PictureCollector) -> str:
    """The page of a report.

    Args:
        report: content of report.json, see `belvedere.studio.report`.
        pictures: the pictures of the same evaluation.
    """
    evaluation = report["evaluation"]
    summary = evaluation["summary"]
    ways = [row["reconstruction"] for row in summary]
    views = _by_view(evaluation["views"])
    lines = _lines(views, ways)
    several = len(ways) > 1
    frame = PageFrame(
        "evaluation", report["title"], report["machine"]["packages"]["belvedere"],
        _lede(evaluation, len(views)), _figures(summary, several),
    )  # fmt: skip
    parts = {
        "table": _table(summary, ways, "summary"),
        "table_note": _table_note(summary, several),
        "all_views": _all_views(evaluation["views"], ways),
        "chart_note": _chart_note(several),
        "legend": legend(lines),
        "chart_wide": psnr_chart(list(views), lines, 1120),
        "chart_narrow": psnr_chart(list(views), lines, 360),
        "first_way": escape(_best(summary)["reconstruction"]),
        "pictures_note": _pictures_note(pictures, len(views)),
        "switch": _switch(ways),
        "cards": "".join(
            _card(name, views[name], pictures.views[name], ways)
            for name in pictures.shown
            if name in pictures.views
        ),
        "meaning": meaning(pictures.gain),
        "facts": _facts(report),
        "command": escape(report["command"] or "(no command was given)"),
    }
    return framed_page(frame, "report", parts)


def _by_view(rows: Sequence[dict[str, Any]]) -> dict[str, dict[str, dict[str, Any]]]:
    """Rows of report.json by view and reconstruction, in their order."""
    views: dict[str, dict[str, dict[str, Any]]] = {}
    for row in rows:
        views.setdefault(row["view"], {})[row["reconstruction"]] = row
    return views


def _lede(evaluation: Mapping[str, Any], held: int) -> str:
    width, height = evaluation["size"]
    count, options = evaluation["view_count"], evaluation["options"]
    best = max(len(row["references"]) for row in evaluation["views"])
    others = (
        f"from the {'best' if best == 1 else f'{best} best'} of the other views by 3D image "
        f"warping, at {width} × {height} pixels."
    )
    every = options["hold_out"]
    plan = f"{held} of {count} views {'was' if held == 1 else 'were'} held out"
    if held == count:
        plan = f"each of the {count} views was held out in turn and predicted"
    else:
        if isinstance(every, int):
            plan += f" (every {_ordinal(every)})"
        plan += f"{', each' if held > 1 else ' and'} predicted"
    return escape(f"{plan[0].upper()}{plan[1:]} {others}")


def _ordinal(n: int) -> str:
    words = {2: "second", 3: "third", 4: "fourth", 5: "fifth", 8: "eighth", 10: "tenth"}
    return words.get(n, f"{n}th")


def _figures(summary: Sequence[Mapping[str, Any]], several: bool) -> list[tuple[str, str, str]]:
    """The four numbers in large type: those of the best way on common pixels."""
    best = _best(summary)
    suffix = f", {best['reconstruction']}" if several else ""
    return [
        (f"PSNR, covered{suffix}", shown_number(best["psnr_covered"], "db"), "dB"),
        ("SSIM, covered", shown_number(best["ssim_covered"], "index"), ""),
        ("Holes", shown_number(best["hole_fraction"], "percent"), "%"),
        ("Render, a view", shown_number(best["ms"], "ms"), "ms"),
    ]


def _best(summary: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """The reconstruction that is best where all can be compared."""
    return max(summary, key=lambda row: _rank(row["psnr_common"]))


def _rank(value: float | str | None) -> float:
    return -math.inf if value is None else float(value)


def _table(rows: Sequence[Mapping[str, Any]], ways: Sequence[str], kind: str) -> str:
    """A reconstruction a row; the best of each column is marked if there are several."""
    head = "".join(
        f'<th scope="col">{name}<small>{unit}</small></th>' for _, name, unit, _, _ in COLUMNS
    )
    best = {
        key: max(sign * _rank(row[key]) for row in rows if row[key] is not None)
        for key, _, _, _, sign in COLUMNS
        if sign and len(rows) > 1 and any(row[key] is not None for row in rows)
    }
    body = ""
    for row in rows:
        name = row["reconstruction"]
        body += (
            f'<tr><th scope="row"><span class="dot way-{ways.index(name) % 5}"></span>'
            f"{escape(name)}</th>"
        )
        for key, label, unit, form, sign in COLUMNS:
            top = row[key] is not None and sign * _rank(row[key]) == best.get(key)
            data = escape(f"{label} {unit}".removesuffix(" dB").strip())
            body += (
                f'<td data-label="{data}"{" class=best" if top else ""}>'
                f"{shown_number(row[key], form)}</td>"
            )
        body += "</tr>"
    return (
        f'<div class="scroll"><table class="{kind}"><thead><tr><th scope="col">Reconstruction</th>'
        f"{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _table_note(summary: Sequence[Mapping[str, Any]], several: bool) -> str:
    views, measured = summary[0]["views"], min(row["measured"] for row in summary)
    text = f"Means over {views} held-out view{'s' if views != 1 else ''}; times are medians."
    if measured < views:
        text += (
            f" Only {measured} of them have covered pixels; the others have no PSNR to take a "
            "mean of, and count in the holes."
        )
    if several:
        text += " Compare reconstructions by the common pixels, which all of them cover."
    return escape(text)


def _all_views(rows: Sequence[Mapping[str, Any]], ways: Sequence[str]) -> str:
    head = "".join(f'<th scope="col">{n}<small>{u}</small></th>' for _, n, u, _, _ in COLUMNS)
    body = "".join(
        f'<tr><th scope="row">{escape(row["view"])}</th><td><span class="dot '
        f'way-{ways.index(row["reconstruction"]) % 5}"></span>{escape(row["reconstruction"])}</td>'
        + "".join(f"<td>{shown_number(row[key], form)}</td>" for key, _, _, form, _ in COLUMNS)
        + "</tr>"
        for row in rows
    )
    return (
        f'<table><thead><tr><th scope="col">View</th><th scope="col">Reconstruction</th>{head}</tr>'
        f"</thead><tbody>{body}</tbody></table>"
    )


def _lines(views: Mapping[str, Mapping[str, Any]], ways: Sequence[str]) -> list[Line]:
    def values(way: str, key: str) -> tuple[float, ...]:
        numbers = (row[way][key] for row in views.values())
        return tuple(math.nan if value is None else float(value) for value in numbers)

    if len(ways) > 1:
        return [Line(way, values(way, "psnr_common"), i % 5) for i, way in enumerate(ways)]
    return [
        Line(f"{ways[0]}, covered pixels", values(ways[0], "psnr_covered"), 0),
        Line(f"{ways[0]}, whole picture, holes filled", values(ways[0], "psnr_whole"), 1, True),
    ]


def _chart_note(several: bool) -> str:
    if several:
        return "On the pixels that every reconstruction covers; higher is better."
    return "On covered pixels and on the whole picture; higher is better."


def _pictures_note(pictures: PictureCollector, held: int) -> str:
    text = (
        "Tap a picture to flip between prediction and truth; they lie exactly on one another. "
        "Predictions are shown with their holes filled: coverage shows what was filled."
    )
    if len(pictures.views) < held:
        text += f" Pictures of {len(pictures.views)} of {held} views, evenly chosen."
    return escape(text)


def _switch(ways: Sequence[str]) -> str:
    if len(ways) < 2:
        return ""
    buttons = "".join(
        f'<button type="button" data-choose="{escape(way)}" aria-pressed="false">{escape(way)}'
        "</button>"
        for way in ways
    )
    return f'<div class="switch" role="group" aria-label="Reconstruction">{buttons}</div>'


def _card(
    name: str, rows: Mapping[str, Mapping[str, Any]], pictures: ViewPictures, ways: Sequence[str]
) -> str:
    first = rows[ways[0]]
    noun = "reference" if len(first["references"]) == 1 else "references"
    from_text = (
        f"{noun} {', '.join(first['references'])}, the nearest {first['nearest_m']:.2f} m away"
    )
    parts = [_figure(pictures.truth, "truth", "Truth", f"{name}: the truth", pictures)]
    numbers = []
    for way in ways:
        images = pictures.ways[way]
        tail = f" ({way})" if len(ways) > 1 else ""
        tail_html = f'<span class="nojs">{escape(tail)}</span>'
        inner = "".join(
            _figure(
                images[kind], kind, kind.capitalize() + tail_html, f"{name}: {text}{tail}", pictures
            )
            for kind, text in (
                ("prediction", "the prediction, holes filled"),
                ("difference", "prediction minus truth, grey where they agree"),
                ("coverage", "covered pixels in grey, holes in rose"),
            )
        )
        parts.append(f'<div data-of="{escape(way)}">{inner}</div>')
        numbers.append(_card_numbers(way, rows[way]))
    size = f'width="{pictures.width}" height="{pictures.height}"'
    return (
        f'<article class="view"><header><h3>{escape(name)}</h3><p class="from">{escape(from_text)}'
        f'</p></header><div class="stage"><button type="button" aria-label="Flip prediction and '
        f'truth"><img {size} alt=""></button><span class="badge"></span></div><div class="side">'
        f'<div class="strip">{"".join(parts)}</div>{"".join(numbers)}</div></article>'
    )


def _figure(uri: str, kind: str, caption: str, alt: str, pictures: ViewPictures) -> str:
    """One picture of the strip; ``caption`` is HTML already."""
    return (
        f'<figure data-kind="{kind}"><button type="button" aria-pressed="false"><img src="{uri}" '
        f'alt="{escape(alt)}" width="{pictures.width}" height="{pictures.height}" '
        f'decoding="async"></button><figcaption>{caption}</figcaption></figure>'
    )


def _card_numbers(way: str, row: Mapping[str, Any]) -> str:
    items = (
        ("PSNR, covered", shown_number(row["psnr_covered"], "db"), "dB"),
        ("PSNR, whole", shown_number(row["psnr_whole"], "db"), "dB"),
        ("SSIM, covered", shown_number(row["ssim_covered"], "index"), ""),
        ("Holes", shown_number(row["hole_fraction"], "percent"), "%"),
        ("Render", shown_number(row["ms"], "ms"), "ms"),
    )
    cells = "".join(
        f"<div><dt>{name}</dt><dd>{value} <small>{unit}</small></dd></div>"
        for name, value, unit in items
    )
    return f'<dl class="numbers" data-of="{escape(way)}">{cells}</dl>'


def _facts(report: Mapping[str, Any]) -> str:
    """When, where, with which options; and what is known about the views."""
    machine, evaluation = report["machine"], report["evaluation"]
    memory = f", {machine['memory_gib']:g} GiB" if machine["memory_gib"] else ""
    packages = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    facts = {
        "Made": str(report["created"]).replace("T", " ").replace("+00:00", " UTC"),
        "Took": f"{evaluation['seconds']:g} s, reading files and measuring included",
        "Processor": f"{machine['cpu']}, {machine['threads']} of {machine['cores']} used{memory}",
        "System": f"{machine['system']}, {machine['python']}",
        "Packages": packages,
        "Options": ", ".join(
            f"{name.replace('_', ' ')} {_plain(value)}"
            for name, value in evaluation["options"].items()
        ),
    }
    facts |= {name.replace("_", " "): _plain(value) for name, value in report["facts"].items()}
    return "".join(
        f"<dt>{escape(name[:1].upper() + name[1:])}</dt><dd>{escape(value)}</dd>"
        for name, value in facts.items()
    )


def _plain(value: Any) -> str:
    """A JSON value as text, cut where it gets long."""
    if isinstance(value, list) and all(isinstance(item, str | int | float) for item in value):
        text = " ".join(map(str, value))
    else:
        text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    text = {"null": "all" if value is None else "null"}.get(text, text)
    return text if len(text) <= 300 else text[:297] + "..."
