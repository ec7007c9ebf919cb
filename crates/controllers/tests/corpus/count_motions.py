"""Lines of motion statements in the programs of a corpus, by the lists of the manuals; knows nothing of the readers.

    python3 count_motions.py krl.txt > krl.json          {"job.src": [4, 7], …}

Motions to where the robot is ($POS_ACT and the like) and of external axes alone (MoveExtJ, ASYPTP) are none. VAL3's data have points in place of motions: lines of their values.
"""

import json
import re
import sys

KRL = "PTP LIN CIRC SPTP SLIN SCIRC SPL PTP_REL LIN_REL CIRC_REL SPTP_REL SLIN_REL SCIRC_REL SPL_REL".split()
RAPID = "MoveJ MoveL MoveC MoveAbsJ TriggJ TriggL TriggC TriggAbsJ TriggJIOs TriggLIOs SearchL SearchC EGMMoveL EGMMoveC".split()
RAPID += [f"Move{way}{more}" for way in "JLC" for more in ("DO", "AO", "GO", "Sync")]
RAPID += "ArcMoveJ ArcMoveL ArcMoveC ArcMoveAbsJ SpotML SpotMJ SpotL SpotJ".split()
RAPID += [f"Arc{way}{more}" for way in "LC" for more in ("", "Start", "End", "1", "2")]
RAPID += [f"{process}{way}" for process in "Paint Disp Cap Cut Glue FCPress Laser Nut Stud Seal Weld Contact".split() for way in "LC"]
RAPID += ["StorePath_Move"]
URSCRIPT = "movej movel movep movec servoj servoc servol mc_add_linear mc_add_circular optimovej optimovel".split()
HERE = ("$POS_ACT", "$AXIS_ACT", "$POS_RET", "$AXIS_RET", "$POS_INT", "$AXIS_INT")


def plain(line, comment, quotes):
    """A line without its comment, with texts blanked out."""
    out, quote = "", None
    for sign in line:
        if quote:
            quote = None if sign == quote else quote
            out += " "
        elif sign in quotes:
            quote = sign
            out += " "
        elif sign == comment:
            break
        else:
            out += sign
    return out


def krl(lines):
    found = []
    for number, line in enumerate(lines, 1):
        words = plain(line, ";", '"').replace("{", " {").split()
        if not words or words[0].upper() not in KRL:
            continue
        if len(words) > 1 and words[1].upper() in HERE:
            continue
        found.append(number)
    return found


def rapid(lines):
    known = {word.upper() for word in RAPID}
    found, header = [], False
    for number, line in enumerate(lines, 1):
        if line.strip() == "%%%":
            header = not header
        if header:
            continue
        text = plain(line, "!", '"')
        for match in re.finditer(r"(?<![\w\\.%:])([A-Za-z_]\w*)(?=\s*(\\|\s|\[|\*|$))", text):
            if match.group(1).upper() in known and not text[match.end():].lstrip().startswith(":="):
                found.append(number)
    return found


def fanuc(lines):
    found, inside = [], False
    for number, line in enumerate(lines, 1):
        if line.strip() == "/MN":
            inside = True
        elif line.strip() == "/POS":
            inside = False
        elif inside and re.match(r"\s*\d+:\s*[JLCAS]\s+PR?\[", line):
            found.append(number)
    return found


def urscript(lines):
    found, depth = [], 0
    for number, line in enumerate(lines, 1):
        text = plain(line, "#", "\"'")
        for word in URSCRIPT:
            found += [number] * len(re.findall(rf"(?<![\w.]){word}\s*\(", text))
    return sorted(found)


def inform(lines):
    found, inside = [], False
    for number, line in enumerate(lines, 1):
        if line.strip() == "//INST":
            inside = True
        elif inside and re.match(r"\s*[+]?(E?I|S|SVSPOT)?MOV[A-Z]*\s", line.split("'")[0] + " "):
            found.append(number)
        elif inside and re.match(r"\s*SVSPOTMOV\s", line):
            found.append(number)
    return found


def val3(lines):
    text = "\n".join(lines)
    text = re.sub(r"<!--.*?-->", lambda match: re.sub(r"[^\n]", " ", match.group()), text, flags=re.S)
    found = []
    for data in re.finditer(r"<Data\b([^>]*)>(.*?)</Data>", text, flags=re.S):
        if re.search(r'\btype="(point|joint)(Rx|Rs)?"', data.group(1)):
            for value in re.finditer(r"<Value\b", data.group(2)):
                found.append(1 + text.count("\n", 0, data.start(2) + value.start()))
    return found


def main(path):
    language = re.search(r"(\w+)\.txt$", path).group(1)
    with open(path, encoding="utf-8", newline="") as file:
        parts = re.split(r"^=== (\S+)\n", file.read(), flags=re.M)[1:]
    count = globals()[language]
    print(json.dumps({name: count(text.split("\n")) for name, text in zip(parts[::2], parts[1::2])}))


main(sys.argv[1])
