"""Says what is wrong with text that is no YAML, in words for someone who did not mean to write YAML tricks."""

import re

from yaml import MarkedYAMLError

_SAME_COLUMN = "lines of one mapping or list begin in the same column"
_TOKENS = {
    "<scalar>": "text",
    "<stream end>": "the end of the file",
    "<block mapping start>": "a mapping",
    "<block sequence start>": "a list",
    "<block end>": "the end of the block",
    "<document start>": "'---'",
    "<document end>": "'...'",
    "<alias>": "an alias",
    "<anchor>": "an anchor",
    "<tag>": "a tag",
}


def explain(error: MarkedYAMLError) -> tuple[int, int, str]:
    """Return line and column, from 1, and a message for an error of PyYAML's scanner or parser."""
    problem, context = str(error.problem or ""), str(error.context or "")
    here, opening = error.problem_mark, error.context_mark
    message, at_opening = _message(problem, context)
    if "parsing a flow node" not in context and "parsing a flow" in context and opening is not None:
        message, at_opening = _unclosed(problem, context, opening.line + 1, opening.column + 1)
    mark = opening if (at_opening and opening is not None) or here is None else here
    return (mark.line + 1, mark.column + 1, message) if mark is not None else (1, 1, message)


def _message(problem: str, context: str) -> tuple[str, bool]:
    """Return a message, and whether it belongs to where the faulty construct begins."""
    if "cannot start any token" in problem:
        return _bad_start(problem), False
    if "scanning a quoted scalar" in context:
        return "this quoted text is not closed", True
    if "double-quoted" in context:
        return f"{problem}; in double quotes a backslash is written \\\\, in single quotes it stands for itself", False
    if re.search("scanning an (alias|anchor)", context):
        begin = "*" if "alias" in context else "&"
        return f"text that begins with {begin!r} needs quotes", True
    if re.search("(scanning|parsing) a tag", context) or "tag handle" in problem:
        return "text that begins with '!' needs quotes; tags are not part of a graph file", True
    if "block scalar" in context:
        return f"{problem}; text that begins with '|' or '>' needs quotes", False
    if "mapping values are not allowed" in problem:
        return f"a ':' does not fit here; text with ': ' in it needs quotes, and {_SAME_COLUMN}", False
    if "sequence entries are not allowed" in problem:
        return "a list does not begin here; write [a, b], or each '- item' on a line of its own", False
    if "could not find expected ':'" in problem:
        return "expected `name: value`, found no ':' behind the name", True
    if "but found" in problem or "but got" in problem:
        return _unexpected(problem), False
    return f"not valid YAML: {problem or context}", False


def _bad_start(problem: str) -> str:
    if "'\\t'" in problem:
        return "a tab; YAML is indented and separated by spaces"
    found = re.search("character (.+) that", problem)
    return f"text that begins with {found.group(1) if found else 'this'} needs quotes"


def _unexpected(problem: str) -> str:
    found = _token(problem)
    if "<document start>" in problem:
        return f"the document has ended before this; {_SAME_COLUMN}"
    if "node content" in problem:
        unclosed = "; a '{' or '[' is not closed" if found == _TOKENS["<stream end>"] else ""
        return f"expected a value, got {found}{unclosed}"
    if found in ("'}'", "']'"):
        return f"{found} closes nothing"
    if "<block end>" in problem:
        return f"the indentation does not fit: got {found} here; {_SAME_COLUMN}"
    return f"not valid YAML: {problem}"


def _unclosed(problem: str, context: str, line: int, column: int) -> tuple[str, bool]:
    begin, end, kind = ("{", "}", "mapping") if "mapping" in context else ("[", "]", "list")
    found = _token(problem)
    if found == "the end of the file":
        return f"this {begin!r} is not closed by {end!r}", True
    message = f"expected ',' or {end!r} of the {kind} that begins at {line}:{column}, got {found}"
    if found in ("'['", "'{'", "'?'"):
        message += "; inside of {} and [] text with brackets or '?' needs quotes, as in type: \"list[Image]\""
    return message, False


def _token(problem: str) -> str:
    found = re.search("but (?:found|got) (.+)$", problem)
    name = found.group(1).strip("'\"") if found else ""
    return _TOKENS.get(name, repr(name))
