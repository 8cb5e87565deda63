"""What agents of CI servers take for commands in a log, by their own documentation: small parsers of their grammars.

GitHub: "Workflow commands", ``::name key=value,...::text`` at the beginning of a line; its runner trims blanks first,
and still reads the form before that, ``##[name key=value;...]text``, anywhere in a line. Azure: "Logging commands",
``##vso[area.action key=value;...]text`` anywhere, and "Formatting commands", ``##[name]text``. TeamCity: "Service
messages", ``##teamcity[name ...]``. GitLab: "Custom collapsible sections", ``section_start:time:name`` before a
carriage return and an escape sequence.
"""

import re
import unicodedata

#: Marks of no width, which a comparison by the rules of a language passes over; agents that compare so read the rest.
_WITHOUT_WIDTH = {"Cf", "Mn", "Me"}
_LINE_ENDS = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029]")


def commands_in(log: str) -> list[str]:
    """The command that each line of a log gives, with the agent that takes it."""
    return [found for line in _LINE_ENDS.split(log) if (found := _command(line)) is not None]


def _command(line: str) -> str | None:
    for text in (line, "".join(one for one in line if unicodedata.category(one) not in _WITHOUT_WIDTH)):
        trimmed = text.lstrip()
        if trimmed.startswith("::") and "::" in trimmed[2:]:
            return f"github {trimmed[2:].split('::')[0].split(' ')[0]}"
        for agent, prefix in (("azure", "##vso["), ("teamcity", "##teamcity["), ("github, azure", "##[")):
            at = text.lower().find(prefix)
            if at >= 0:
                return f"{agent} {text[at + len(prefix) :].split(']')[0].split(' ')[0]}"
        if re.search(r"section_(start|end):\d+:[^\r]*\x1b\[", text):
            return "gitlab section"
    return None
