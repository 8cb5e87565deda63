"""The controller dialects: one file of this folder each, which defines ``DIALECT``. All end in one Moves table.

The table is made from the files; the file's name is the value of ``--dialect``.
"""

import re
from collections.abc import Mapping
from importlib import import_module
from typing import Final

from verne_post.base.long_text import Text
from verne_post.base.modules import list_module_names
from verne_post.gcode.dialect import Dialect

#: Stands for the dialect that the first lines show.
_AUTO: Final = "auto"
#: After the ending of a file: some CAM systems count versions, as in part.ncl.3.
_VERSION: Final = re.compile(r"\.\d+$")
#: The dialect of a text that none recognises, in a file whose ending says nothing.
_DEFAULT: Final = "rs274"


DIALECTS: Final[Mapping[str, Dialect]] = {
    name: import_module(f"{__name__}.{name}").DIALECT for name in list_module_names(__path__)
}


def name_dialect(dialect: Dialect) -> str:
    """The name of a dialect, as ``--dialect`` takes it."""
    return next(name for name, other in DIALECTS.items() if other is dialect)


def choose_dialect(name: str, source: Text, source_name: str) -> Dialect:
    """The named dialect; for "auto" the one of the text, else of the file's ending, else RS274/NGC."""
    return DIALECTS[choose_dialect_name(name, source, source_name)]


def choose_dialect_name(name: str, source: Text, source_name: str) -> str:
    """The name of that dialect."""
    return find_dialect_name(name, source, source_name) or _DEFAULT


def find_dialect_name(name: str, source: Text, source_name: str) -> str:
    """The name of the dialect that is named, or that the text or the file's ending shows; empty where nothing does."""
    if name != _AUTO:
        return name
    name_alone = _VERSION.sub("", source_name.lower())
    endings = [(one, dialect) for one, dialect in DIALECTS.items() if name_alone.endswith(dialect.endings)]
    by_title = (one for one, dialect in endings if dialect.has_title(source))
    by_text = (dialect_name for dialect_name, dialect in DIALECTS.items() if dialect.recognise(source))
    return next(by_title, "") or next(by_text, "") or next((one for one, _dialect in endings), "")
