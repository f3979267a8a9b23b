"""The pages on the Fortran side, from the lines `!>` of the sources: a page a folder of src/geartrain, a section a module."""

import re

__all__ = ["write"]

PROCEDURE = re.compile(r"(?!end\b)((?:pure|elemental|recursive|impure|module|real\(dp\)|complex\(dp\)|integer|logical|type\(\w+\)|"
                       r"character\([^)]*\)|\s)*)(subroutine|function)\s+(\w+)\s*\(([^)]*)\)(.*)", re.IGNORECASE)
TYPE = re.compile(r"type\s*(?:,[^:]*)?(?:::)?\s*(?!\()(\w+)$", re.IGNORECASE)
DECLARATION = re.compile(r"([^!']*?)\s*::\s*(.*)")


def write(sources, folder):
    """Write the pages into a folder; those that are as they were keep their time stamps."""
    folder.mkdir(exist_ok=True)
    door = (sources / "geartrain.f90").read_text(encoding="utf-8")
    offered = {name: module for module, names in re.findall(r"use (\w+), only: (.*)", door) for name in names.split(", ")}
    folders = sorted((sources / "geartrain").iterdir())
    pages = {path.name: "\n".join([f"# {path.name}\n", *map(section, sorted(path.glob("*.f90")))]) for path in folders}
    pages["index"] = index(offered, pages)
    for name, text in pages.items():
        page = folder / f"{name}.md"
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def index(offered, pages):
    """The page of what `use geartrain` gives."""
    lines = [
        "# Fortran", "", "`use geartrain` offers all that a caller needs; `example/response_curve.f90` and",
        "`example/time_integration.f90` are whole programs. What the library is made of stands in its folders below;",
        "[code.md](../code.md) tells which of them may use which.", "", "| name | of |", "|---|---|",
    ]
    told = "".join(pages.values())
    for name, module in sorted(offered.items()):
        link = f"[`{name}`](#{anchor(module, name)})" if f"({anchor(module, name)})=" in told else f"`{name}`"
        lines.append(f"| {link} | [`{module}`](#{anchor(module)}) |")
    return "\n".join([*lines, "", "```{toctree}", ":maxdepth: 1", "", *pages, "```", ""])


def section(path):
    """The section of a module: what it is for, its public types and procedures."""
    lines = list(statements(path))
    told, code = next((told, code) for told, code in lines if code.lower().startswith("module "))
    module = code.split()[1]
    public = {name for _, code in lines if re.match(r"public\s*::", code) for name in re.findall(r"\w+", code.split("::")[1])}
    text = [f"({anchor(module)})=", f"## {escaped(module)}", "", prose(told), ""]
    bound = {name for _, code in lines if re.match(r"procedure\b(?!.*\bprivate\b).*::", code) for name in re.findall(r"\w+", code)}
    for place, (told, code) in enumerate(lines):
        match, type_ = PROCEDURE.match(code), TYPE.match(code)
        if type_ and type_[1] in public:
            text += [f"({anchor(module, type_[1])})=", f"### {escaped(type_[1])}", "", f"`{code}`", "", prose(told), "",
                     *members(lines[place + 1:])]
        elif re.match(r"interface\s+\w+$", code) and code.split()[1] in public:
            # A constructor has its type's name, and the type has the anchor.
            of_type = any(type_ and type_[1] == code.split()[1] for type_ in (TYPE.match(code) for _, code in lines))
            text += [*([] if of_type else [f"({anchor(module, code.split()[1])})="]), f"### {escaped(code.split()[1])}", "",
                     prose(told), ""]
        elif match and (match[3] in public or match[3] in bound):
            public_name = match[3] in public
            text += [*([f"({anchor(module, match[3])})="] if public_name else []), f"### {escaped(match[3])}", "",
                     f"`{' '.join(code.split())}`", "", prose(told), "", *arguments(lines[place + 1:], match[4], match[5])]
        elif re.match(r".*\bparameter\b.*::", code):
            for name in public & set(re.findall(r"(\w+)\s*=", code)):
                text += [f"({anchor(module, name)})=", f"### {escaped(name)}", "", f"`{code}`", "", prose(told), ""]
    return "\n".join(text)


def statements(path):
    """What the lines `!>` above tell, and the statement, of each statement of a file; continued lines are joined."""
    told, joined = [], ""
    for line in path.read_text(encoding="utf-8").splitlines():
        line = line.strip()
        if line.startswith("!>"):
            told.append(line[2:])
        elif line.startswith("!") or (not line and joined):
            continue
        elif not line:
            told = []
        else:
            joined += re.sub(r"\s*!(?!.*').*", "", line).lstrip("&")
            if joined.endswith("&"):
                joined = joined[:-1]
                continue
            yield told, joined
            told, joined = [], ""


def members(lines):
    """The components of a type up to its bound procedures."""
    return declarations(lines, lambda code: re.match(r"(end type|contains)\b", code), lambda code, name: "private" not in code)


def arguments(lines, names, ending):
    """The arguments of a procedure and its result."""
    known = {*re.findall(r"\w+", names), *re.findall(r"result\s*\((\w+)\)", ending)} - {"self"}
    return declarations(lines, lambda code: re.match(r"(end|contains)\b", code) or PROCEDURE.match(code),
                        lambda code, name: name in known)


def declarations(lines, ends, wanted):
    """Rows of a table of declarations, with what is told above them."""
    rows, last = [], []
    for told, code in lines:
        if ends(code):
            break
        match = DECLARATION.match(code)
        if not match:
            continue
        last = told or last
        right = re.sub(r"\((?:[^()]|\([^()]*\))*\)|=.*?(?=,|$)|\[[^]]*\]", "", match[2])
        names = [name for name in re.findall(r"\w+", right) if wanted(code, name)]
        if names:
            rows.append(f"| {', '.join(f'`{name}`' for name in names)} | `{match[1]}` | {prose(told).replace(chr(10), ' ')} |")
    return ["| name | type | |", "|---|---|---|", *rows, ""] if rows else []


def prose(told):
    """Lines `!>` as Markdown: lines set in by more than the text are formulas."""
    text, formula = [], []
    for line in [*told, ""]:
        if line.startswith("   "):
            formula.append(line.strip())
            continue
        if formula:
            text += ["", "```text", *formula, "```", ""]
            formula = []
        text.append(escaped(line.strip()))
    return "\n".join(text).strip()


def escaped(line):
    """A line without anything that Markdown reads as its own, apart from code in back quotes."""
    pieces = re.split(r"(`[^`]*`)", line)
    return "".join(piece if piece.startswith("`") else re.sub(r"([\\*_<>|$#\[\]~])", r"\\\1", piece) for piece in pieces)


def anchor(*names):
    return "-".join(names).replace("_", "-").lower()
