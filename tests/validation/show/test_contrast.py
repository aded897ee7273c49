"""Words can be told from what they stand on: WCAG 2.2, 1.4.3, a contrast of 4.5 for small text."""

import re

from tactgen.validation.show.page import asset

LEAST = 4.5


def luminance(colour):
    """Return the relative luminance of #rgb or #rrggbb, as WCAG defines it."""
    digits = colour.lstrip("#")
    digits = "".join(2 * d for d in digits) if len(digits) == 3 else digits
    parts = [int(digits[k : k + 2], 16) / 255.0 for k in (0, 2, 4)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def variables(css):
    """Return the colours of each block that sets some, in order: light, then dark if there is."""
    blocks = [dict(re.findall(r"--([\w-]+):\s*(#[0-9a-fA-F]{3,6})", b)) for b in css.split("}")]
    return [block for block in blocks if block]


def test_the_viewers_words():
    """Ink, dimmed ink and accent on paper, stage and what is marked, light and dark."""
    schemes = variables(asset("viewer.css"))
    assert len(schemes) == 2
    for scheme in schemes:
        for word in ("tv-ink", "tv-dim"):
            for ground in ("tv-paper", "tv-stage", "tv-mark"):
                assert contrast(scheme[word], scheme[ground]) >= LEAST, (word, ground)
        assert contrast(scheme["tv-accent"], scheme["tv-paper"]) >= LEAST


def test_the_displays_words():
    """Its words and notes, light and dark."""
    light, dark = asset("display.css").split("@media (prefers-color-scheme: dark)")
    for css in (light, dark):
        ground = re.search(r"\.td \{[^}]*background: (#\w+)", css)[1]
        words = re.findall(r"[; {]color: (#\w+)", css)
        assert len(words) == 2
        assert all(contrast(word, ground) >= LEAST for word in words), (words, ground)
