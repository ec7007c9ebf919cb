#!/usr/bin/env python3
"""Spoils good.csv in the ways in which tables get spoiled. Run in this folder."""
import pathlib
import random

good = pathlib.Path("good.csv").read_text()
lines = good.splitlines()
head, rows = lines[0].split(","), [line.split(",") for line in lines[1:]]
NAMES = {name.split("[")[0]: k for k, name in enumerate(head)}


def write(name, text, encoding="utf-8", newline="\n"):
    pathlib.Path(name + ".csv").write_bytes(text.replace("\n", newline).encode(encoding))


def table(head, rows, sep=","):
    return "\n".join(sep.join(r) for r in [head, *rows]) + "\n"


def cell(name, row, column, text):
    changed = [list(r) for r in rows]
    changed[row][NAMES[column]] = text
    write(name, table(head, changed))


def header(name, column, text):
    changed = list(head)
    changed[NAMES[column]] = text
    write(name, table(changed, rows))


def more(name, title, value):
    write(name, table(head + title.split(","), [r + value(k).split(",") for k, r in enumerate(rows)]))


# Read as if nothing were: the same table in another dress.
pathlib.Path("fine_bom.csv").write_bytes(b"\xef\xbb\xbf" + good.encode())
write("fine_crlf", good, newline="\r\n")
write("fine_comments", "# a tracker wrote this\n" + good.replace("\n", "\n# between rows\n", 3))
write("fine_blank_lines", good.replace("\n", "\n\n", 4) + "\n\n")
write("fine_quoted", table([f'"{h}"' for h in head], [[f'"{c}"' for c in r] for r in rows]))
write("fine_spaces", table([f" {h} " for h in head], [[f"  {c} " for c in r] for r in rows]))
write("fine_no_last_newline", good.rstrip("\n"))
write("fine_exponents", table(head, [[f"{float(c)*1e3:+.6f}E-3" if k < 6 else c for k, c in enumerate(r)] for r in rows]))
order = list(range(len(head)))
random.Random(4).shuffle(order)
write("fine_columns_permuted", table([head[k] for k in order], [[r[k] for k in order] for r in rows]))
metres = [f"{h.split('[')[0]}[m]" if "[mm]" in h else h for h in head]
write("fine_metres", table(metres, [[f"{float(c)/1e3:.9f}" if "[mm]" in h else c for h, c in zip(head, r)] for r in rows]))

# Encodings and forms.
write("utf16", good, encoding="utf-16")
write("utf16_without_mark", good, encoding="utf-16-le")
write("latin1", good.replace("j1[deg]", "j1[°]"), encoding="latin-1")
write("carriage_returns_only", good, newline="\r")
pathlib.Path("nul_bytes.csv").write_bytes(good.replace(",", ",\0", 9).encode())
write("decimal_commas", good.replace(".", ","))
write("decimal_commas_and_semicolons", good.replace(",", ";").replace(".", ","))
write("semicolons", good.replace(",", ";"))
write("tabs", good.replace(",", "\t"))
write("mixed_separators", "\n".join(l.replace(",", ";") if k % 3 == 2 else l for k, l in enumerate(lines)) + "\n")
cell("thousands_quoted", 3, "x", '"1,234.5"')
cell("thousands_apostrophe", 3, "x", "1'234.5")
cell("thousands_space", 3, "x", "1 234.5")
write("row_of_units", lines[0] + "\ndeg,deg,mm,mm,mm,mm,-,-\n" + "\n".join(lines[1:]) + "\n")
write("no_header", "\n".join(lines[1:]) + "\n")
write("header_twice", "\n".join(lines[:6] + lines[:1] + lines[6:]) + "\n")
write("two_files_in_one", good + good.replace("x[mm],y[mm]", "y[mm],x[mm]"))
write("totals", good + "mean,,,1.0,2.0,3.0,,\n")
write("fine_trailing_commas", table(head, [r + [""] for r in rows]))
write("unclosed_quote", good.replace("T1", '"T1', 1))
write("only_comments", "# nothing\n# at all\n")
write("only_a_header", lines[0] + "\n")
write("empty", "")
pathlib.Path("gzip.csv").write_bytes(b"\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03" + bytes(range(200, 256)))
pathlib.Path("spreadsheet.csv").write_bytes(b"PK\x03\x04\x14\x00\x06\x00\x08\x00" + bytes(range(128, 190)))
write("web_page", "<!doctype html>\n<html><head><title>Please log in</title></head>\n<body>Session expired</body></html>\n")
write("json", '[{"j1": 0.1, "x": 3.0}]\n')

# Cells.
for name, text in [
    ("hexadecimal", "0x1F"), ("fraction", "1/2"), ("with_unit", "12.5 mm"), ("missing_na", "NA"), ("missing_dash", "-"),
    ("nan", "nan"), ("infinite", "inf"), ("overflow", "1e999"), ("huge", "1e300"), ("digit_letters", "1O0.5"),
    ("two_points", "1.2.3"), ("minus_sign_of_typography", "\u2212101.5"), ("formula", "=A2+1"), ("excel_error", "#REF!"),
]:
    cell("cell_" + name, 4, "x", text)
cell("cell_subnormal", 4, "x", "4.9e-324")
cell("joint_empty", 5, "j1", "")
cell("joint_beyond_two_turns", 5, "j1", "90000")
header("joint_degrees_under_rad", "j2", "j2[rad]")
cell("target_unknown", 5, "target", "T9")
cell("target_empty", 5, "target", "")
cell("target_escape_sequence", 5, "target", "\x1b[2JT1")
cell("visit_fraction", 5, "visit", "1.5")
cell("visit_huge", 5, "visit", "99999999999999999999999")
cell("visit_of_other_joints", 5, "visit", rows[0][NAMES["visit"]])
header("unit_unknown", "x", "x[furlong]")
header("unit_of_something_else", "x", "x[kg]")
header("unit_unclosed", "x", "x[mm")
header("unit_missing", "x", "x")
header("joint_missing", "j2", "j_two[deg]")
header("column_twice", "x", "y[mm]")
header("column_nameless", "x", "")
more("time_of_day", "time[s]", lambda k: f"12:{k:02}:07")
more("time_backwards", "time[s]", lambda k: str(100 - 3 * (k // 2)))
more("payload_negative", "payload[kg]", lambda k: "-5" if k == 3 else "5")
more("payload_text", "payload[kg]", lambda k: "heavy" if k == 3 else "5")
more("payload_zero", "payload[kg]", lambda k: "0")
more("centre_of_gravity_without_payload", "cx[mm],cy[mm],cz[mm]", lambda k: "1,2,3")
more("quaternion_zero", "qw,qx,qy,qz", lambda k: "0,0,0,0")
more("quaternion_long", "qw,qx,qy,qz", lambda k: "1,1,0,0")
more("quaternion_partly", "qw,qx,qy", lambda k: "1,0,0")
more("wrench_partly", "fx[N],fy[N],fz[N]", lambda k: "1,2,3")
more("approach_of_two", "approach_j1", lambda k: "2")
more("approach_of_nobody", "approach_j7", lambda k: "1")
more("deviation_negative", "sx[mm],sy[mm],sz[mm]", lambda k: "-1,1,1")
more("deviation_zero", "sx[mm],sy[mm],sz[mm]", lambda k: "0,0,0")
more("channel_text", "operator", lambda k: "Anna" if k % 2 else "Bert")
write("copied_rows", "\n".join(lines + [lines[3].rsplit(",", 1)[0] + ",77", lines[4].rsplit(",", 1)[0] + ",77"]) + "\n")
still = [list(r) for r in rows]
for r in still:
    r[NAMES["d3"]] = "50.000"
write("joint_that_never_moves", table(head, still))
write("one_configuration", table(head, [rows[0][: NAMES["x"]] + r[NAMES["x"]:] for r in rows]))
write("one_row", "\n".join(lines[:2]) + "\n")
write("nothing_measured", table(head, [["" if h[0] in "xyz" else c for h, c in zip(head, r)] for r in rows]))

# Descriptions of robots.
robot = pathlib.Path("robot.toml").read_text()


def described(name, text, ending="toml"):
    pathlib.Path(f"robot_{name}.{ending}").write_text(text)


described("typing_error", robot.replace("limits", "limit", 1))
described("two_of_a_name", robot.replace('"j2"', '"j1"'))
described("limits_reversed", robot.replace("[-170, 170]", "[170, -170]"))
described("no_joints", robot[: robot.index("[[joints]]")])
described("unit_unknown", robot.replace('"mm"', '"furlong"'))
described("type_unknown", robot.replace('"prismatic"', '"ball"'))
described("text_for_a_number", robot.replace("a = 150", 'a = "150"'))
described("not_a_number", robot.replace("a = 150", "a = nan"))
described("huge", robot.replace("a = 150", "a = 1e300"))
described("two_placements", robot.replace("dh = {", "mdh = { theta = 0, d = 0, a = 0, alpha = 0 }\ndh = {", 1))
described("joint_called_x", robot.replace('"j1"', '"x"'))
described("cut_off", robot[: robot.index("alpha = 80")])
described("mass_negative", robot.replace("dh =", "mass = -3\ndh =", 1))
described("gravity_of_two", 'gravity = [0, -9.81]\n' + robot)
described("urdf_missing", 'urdf = "nowhere.urdf"\n')
described("urdf_is_itself", 'urdf = "robot_urdf_is_itself.toml"\n')
link = '<link name="{}"/>'
joint = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><axis xyz="{}"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'


def urdf(name, links, joints, more=""):
    body = "\n".join([link.format(l) for l in links] + [joint.format(*j) for j in joints])
    described(name, f'<robot name="arm">\n{body}\n{more}</robot>\n', "urdf")


urdf("ring", ["a", "b"], [("j1", "revolute", "a", "b", "0 0 1"), ("j2", "revolute", "b", "a", "0 0 1")])
urdf("child_missing", ["a"], [("j1", "revolute", "a", "b", "0 0 1")])
urdf("axis_zero", ["a", "b"], [("j1", "revolute", "a", "b", "0 0 0")])
urdf("axis_of_two", ["a", "b"], [("j1", "revolute", "a", "b", "0 1")])
urdf("floating", ["a", "b"], [("j1", "floating", "a", "b", "0 0 1")])
urdf("two_parents", ["a", "b", "c"], [("j1", "revolute", "a", "c", "0 0 1"), ("j2", "revolute", "b", "c", "0 0 1")])
urdf("nothing_moves", ["a", "b"], [("j1", "fixed", "a", "b", "0 0 1")])
described("unclosed", '<robot name="arm"><link name="a">', "urdf")
described("other_root", '<model name="arm"/>\n', "urdf")
described("entities", '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>\n<robot name="&b;"/>\n', "urdf")
described("web_page", "<!doctype html>\n<html><body>404</body></html>\n", "urdf")

# Declared models.
for name, text in [
    ("family_unknown", '[[effects]]\nfamily = "geometrc"\n'),
    ("joint_unknown", '[[effects]]\nfamily = "joint_compliance"\njoints = ["j9"]\n'),
    ("key_unknown", '[[effects]]\nfamily = "geometric"\nframe = ["base"]\n'),
    ("number_for_a_list", '[[effects]]\nfamily = "geometric"\nframes = 3\n'),
    ("empty", ""),
    ("twice_the_same", '[[effects]]\nfamily = "geometric"\n\n[[effects]]\nfamily = "geometric"\n'),
    ("channel_missing", '[[effects]]\nfamily = "thermal"\njoint = "j1"\nchannel = "temperature"\n'),
    ("period_zero", '[[effects]]\nfamily = "transmission"\njoint = "j1"\nperiod = 0\n'),
    ("no_toml", "effects: [geometric]\n"),
]:
    pathlib.Path(f"model_{name}.toml").write_text(text)

# Desired poses.
for name, text in [
    ("z_missing", "x[mm],y[mm]\n1,2\n"),
    ("empty_position", "x[mm],y[mm],z[mm]\n1,2,\n"),
    ("unknown_target", "x[mm],y[mm],z[mm],target\n1,2,3,T7\n"),
    ("far_away", "x[mm],y[mm],z[mm]\n1e6,0,0\n"),
    ("in_metres", "x[m],y[m],z[m]\n300,200,400\n"),
]:
    pathlib.Path(f"poses_{name}.csv").write_text(text)

# Fits.
for name, text in [
    ("empty", ""),
    ("no_json", "truepose\n"),
    ("other_json", '{"name": "something else"}\n'),
    ("newer", '{"format": 99, "program": "truepose 42.0.0"}\n'),
    ("array", "[1, 2, 3]\n"),
]:
    pathlib.Path(f"fit_{name}.json").write_text(text)
