"""Tables as aligned text and as HTML, as results print themselves at a prompt and in a notebook."""

from collections.abc import Sequence
from itertools import groupby


def format_table(rows: Sequence[Sequence[str]]) -> str:
    """Rows as aligned text."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def format_html_table(rows: Sequence[Sequence[str]]) -> str:
    """Rows as an HTML table for notebooks, the first one the header; numbers stand to the right."""
    import html  # its table of entities takes a millisecond, which only notebooks need

    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in rows[0])
    body = "".join(
        "<tr>" + "".join(f'<td style="text-align: {_align(cell)}">{html.escape(cell)}</td>' for cell in row) + "</tr>"
        for row in rows[1:]
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def format_html_text(text: str) -> str:
    """Text for notebooks, line by line as it is."""
    import html  # as above

    return f"<pre>{html.escape(text)}</pre>"


def format_html_sections(text: str) -> str:
    """Text of heads and indented lines for notebooks: each line is a row, what it names in a column of its own."""
    import html  # as above

    def make_row(line: str) -> str:
        gap = next((gap for gap in ("  ", ": ") if gap in line), "")
        cells = [line] if not gap else [cell.strip() for cell in line.split(gap, 1)]
        width = "" if gap else " colspan=2"
        return "".join(f'<td{width} style="text-align: left">{html.escape(cell)}</td>' for cell in cells)

    return "".join(
        f"<table>{''.join(f'<tr>{make_row(line.strip())}</tr>' for line in lines)}</table>"
        if is_indented
        else "".join(f"<p><strong>{html.escape(line)}</strong></p>" for line in lines)
        for is_indented, lines in groupby(filter(None, text.splitlines()), lambda line: line.startswith(" "))
    )


def _align(cell: str) -> str:
    return "right" if cell.replace(".", "").removeprefix("-").isdecimal() else "left"
