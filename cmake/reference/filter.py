"""Doxygen's input filter: turns our plain comments into documentation.

A comment directly above a declaration, or after it on the same line, documents
it; the comment at the head of a file documents the file. Indented lines of a
comment keep their layout. Prints the header with Doxygen's comment marks.
"""

import re
import sys

COMMENT = re.compile(r"^(\s*)//(?!/)(.*)$")
BEHIND = re.compile(r"^(?P<code>.*\S.*?)\s*//(?!/)\s?(?P<text>.*)$")


def escaped(text):
    text = re.sub(r'([\\@<>&#%$])', r"\\\1", text)
    # The dots of a range (0 .. 1) do not end the first sentence.
    return text.replace(".. ", "..&nbsp;")


def block(lines, begin):
    """The comment lines from `begin` on, as (indent, text) pairs."""
    found = []
    while begin + len(found) < len(lines):
        match = COMMENT.match(lines[begin + len(found)])
        if not match:
            break
        found.append((match.group(1), match.group(2).rstrip()))
    return found


def documentation(comment, first=None):
    """A comment as Doxygen's lines, with indented lines as verbatim blocks."""
    indent = comment[0][0]
    out = [] if first is None else [f"{indent}/// {first}"]
    verbatim = False
    for _, text in comment:
        is_layout = text.startswith("   ")
        if is_layout and not verbatim:
            out.append(f"{indent}/// \\verbatim")
        if verbatim and not is_layout and text.strip():
            out.append(f"{indent}/// \\endverbatim")
            verbatim = False
        verbatim = verbatim or is_layout
        body = text if verbatim else escaped(text)
        out.append(f"{indent}///{body}".rstrip())
    if verbatim:
        out.append(f"{indent}/// \\endverbatim")
    return out


def documents(code, text):
    """Whether a comment after code on the same line documents a declaration."""
    code = code.strip()
    if code.startswith(("#", "}")) or code.endswith("{"):
        return False
    return '"' not in code and not text.startswith("NOLINT")


def main(path):
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    out = []
    k = 0
    column = None  # of the comment after the code of the previous line
    while k < len(lines):
        comment = block(lines, k)
        if comment:
            indent = len(comment[0][0])
            after = lines[k + len(comment)] if k + len(comment) < len(lines) else ""
            if column is not None and indent == column:
                # Continues the comment after the code of the line above.
                out.append(f"{comment[0][0]}///< {escaped(comment[0][1].strip())}")
                k += 1
                continue
            if k == 0:
                out += documentation(comment, "\\file")
            elif after.strip() and not comment[0][1].startswith(" ---"):
                out += documentation(comment)
            k += len(comment)
            column = None
            continue
        match = BEHIND.match(lines[k])
        if match and documents(match["code"], match["text"]):
            column = lines[k].index("//", len(match["code"]))
            out.append(f"{match['code']}  ///< {escaped(match['text'].strip())}")
        else:
            column = None
            out.append(lines[k])
        k += 1
    print("\n".join(out))


main(sys.argv[1])
