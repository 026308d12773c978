"""Occlusion-compatible order in the nine epipole regions, by the library's own rule."""

from __future__ import annotations

from pen import FAINT, INK, ORANGE, SOFT, TEAL, Pen

from belvedere.warp import occlusion_compatible_sheets


def regions() -> str:
    """Nine pictures, the epipole left of, inside or right of each; above, inside or below."""
    pen = Pen(720, 470, "The order of painting in the nine regions that the epipole may lie in.")
    width, height = 96, 66
    for row, e_y in enumerate((-18.0, 26.0, 84.0)):
        for column, e_x in enumerate((-24.0, 40.0, 120.0)):
            left, top = 74 + column * 220, 96 + row * 130
            pen.box(left, top, width, height, "#ffffff", INK, 0)
            sheets = occlusion_compatible_sheets((e_x, e_y, 1.0), width, height)
            for sheet in sheets:
                x0, x1 = left + sheet.u_low, left + sheet.u_high
                y0, y1 = top + sheet.v_low, top + sheet.v_high
                if len(sheets) > 1:
                    pen.line([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], FAINT, 1.2, closed=True)
                for k in range(1, 4):
                    y = y0 + k * (y1 - y0) / 4
                    ends = (x0 + 5, x1 - 5) if sheet.u_step > 0 else (x1 - 5, x0 + 5)
                    pen.arrow((ends[0], y), (ends[1], y), TEAL, 1.2, head=6)
                x = (x0 if sheet.u_step > 0 else x1) + 3.5 * sheet.u_step
                ends = (y0 + 4, y1 - 4) if sheet.v_step > 0 else (y1 - 4, y0 + 4)
                pen.arrow((x, ends[0]), (x, ends[1]), SOFT, 1.2, head=6)
            pen.box(left, top, width, height, "none", INK, 0)
            pen.dot((left + e_x, top + e_y), ORANGE, 5)
    pen.text((360, 30), "Far before near, without comparing depths", INK, 16, "middle", "bold")
    pen.text((360, 50), "orange: the epipole, where the reference sees the desired eye; "
             "arrows: the order of painting", SOFT, 12, "middle")  # fmt: skip
    return pen.sheet()
