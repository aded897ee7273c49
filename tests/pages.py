"""The visible words of an HTML page, and figures that cost no drawing."""

import re


def page_text(page):
    """Return the words of a page, a line for each paragraph, row or title."""
    text = re.sub(r"<(style|script|metadata)\b.*?</\1>", " ", page, flags=re.DOTALL)
    text = re.sub(r"</?(p|div|h\d|tr|li|section|table|figure|figcaption)\b[^>]*>", "\n", text)
    text = re.sub(r"<t[dh]\b[^>]*>", " | ", text)
    text = re.sub(r"<[^>]+>", "", text)
    lines = (" ".join(line.split()) for line in text.splitlines())
    return "\n".join(line for line in lines if line)


def blank_figures(patch):
    """Write every figure as an empty drawing, given a monkeypatch."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    from tactgen.validation.show import figures

    patch.setattr(figures, "lay_out", lambda _: None)
    patch.setattr(FigureCanvasSVG, "print_svg", lambda _, file, **__: file.write("<svg></svg>"))
