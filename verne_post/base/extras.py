"""How to install what an extra of this package brings: the package itself is in no registry, what it needs is."""

import re


def spell_install(extra: str) -> str:
    """The command that installs the package of an extra."""
    from importlib.metadata import PackageNotFoundError, requires  # who has the package needs it not

    try:
        needs = requires("verne-post") or []
    except PackageNotFoundError:  # run from its folder, without an installation
        needs = []
    found = [one.partition(";")[0].strip() for one in needs if re.search(rf"extra == ['\"]{extra}['\"]", one)]
    return f"pip install '{found[0]}'" if found else f"pip install '.[{extra}]'"
