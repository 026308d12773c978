"""What the words on a report's page mean, for a reader who meets them for the first time."""

from __future__ import annotations

MEANING: tuple[tuple[str, str], ...] = (
    (
        "Held out",
        "A held-out picture is never shown to the predictor, neither as a reference for itself "
        "nor for another one. Only its camera is.",
    ),
    (
        "PSNR",
        "How far a prediction is from the truth, in decibels, on sRGB-encoded values. 6 dB "
        "more is half the error. Above 30 dB differences are hard to see; below 20 dB they are "
        "plain. Averages over views are averages of decibels.",
    ),
    (
        "SSIM",
        "Structural similarity of the luma in 11 x 11 windows (Wang 2004): 1 is identical. Beside "
        "a hole, a window looks only at the pixels that are known.",
    ),
    (
        "Covered",
        "Only pixels that the references saw. It says how well colours were carried over, and "
        "nothing about what is missing: a prediction with large holes can score well here.",
    ),
    (
        "Common",
        "Only pixels that every compared reconstruction covers, so that none gains by leaving "
        "difficult pixels out. This is the column to compare reconstructions by.",
    ),
    (
        "Whole",
        "Every pixel. Filled: holes take the colour of the farther surface beside them, which is "
        "a guess, counted as what it shows. Black: holes stay black, and cost what black costs.",
    ),
    (
        "Holes",
        "Pixels that got no sample: no reference saw what is there (it lies behind things or "
        "outside every picture, or its depth is missing), or the reconstruction leaves gaps "
        'between its samples. <span class="hole"></span> marks them in the coverage and '
        "difference pictures. What no reference saw, no method that moves pixels can know; more or "
        "better placed references can.",
    ),
    (
        "Render",
        "Median time of one warp, after a first one that may compile and that prepares the "
        "references; reading files and filling holes are not in it.",
    ),
    (
        "Difference",
        "Prediction minus truth: grey where they agree, lighter where the prediction is too "
        "light, coloured where its colour is off. Enlarged {gain:g} times.",
    ),
)
"""What each word means. HTML; {gain} is put in."""


def meaning(gain: float) -> str:
    """An HTML list of `MEANING`; ``gain`` is how much difference pictures enlarge."""
    rows = "".join(f"<dt>{word}</dt><dd>{text}</dd>" for word, text in MEANING)
    return f'<dl class="meaning">{rows.replace("{gain:g}", f"{gain:g}")}</dl>'
