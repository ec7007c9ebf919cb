"""Writes office.xlsx: two sheets as a spreadsheet program saves them, the second with a title, a header and two rows of measurements.

python3 make.py
"""

import zipfile

TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="xml" ContentType="application/xml"/>
<Override PartName="/xl/workbook.xml" ContentType="application/vnd.openxmlformats-officedocument.spreadsheetml.sheet.main+xml"/>
<Override PartName="/xl/worksheets/sheet1.xml" ContentType="application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml"/>
<Override PartName="/xl/worksheets/sheet2.xml" ContentType="application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml"/>
<Override PartName="/xl/styles.xml" ContentType="application/vnd.openxmlformats-officedocument.spreadsheetml.styles+xml"/>
</Types>"""
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
PACKAGE = "http://schemas.openxmlformats.org/package/2006/relationships"
MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
RELATIONS = f"""<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="{PACKAGE}"><Relationship Id="r1" Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>"""
BOOK = f"""<?xml version="1.0" encoding="UTF-8"?>
<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets>
<sheet name="Info" sheetId="1" r:id="r1"/><sheet name="Messung 3" sheetId="2" r:id="r2"/></sheets></workbook>"""
BOOK_RELATIONS = f"""<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="{PACKAGE}">
<Relationship Id="r1" Type="{OFFICE}/worksheet" Target="worksheets/sheet1.xml"/>
<Relationship Id="r2" Type="{OFFICE}/worksheet" Target="worksheets/sheet2.xml"/>
<Relationship Id="r3" Type="{OFFICE}/styles" Target="styles.xml"/></Relationships>"""
# Style 1 is a date with a clock time.
STYLES = f"""<?xml version="1.0" encoding="UTF-8"?>
<styleSheet xmlns="{MAIN}"><fonts count="1"><font/></fonts><fills count="1"><fill/></fills><borders count="1"><border/></borders>
<cellStyleXfs count="1"><xf/></cellStyleXfs><cellXfs count="2"><xf numFmtId="0"/><xf numFmtId="22" applyNumberFormat="1"/></cellXfs></styleSheet>"""


def sheet(rows):
    """Rows of cells: texts, numbers, none, or a date as ("date", serial number)."""
    out = []
    for number, row in enumerate(rows, 1):
        cells = []
        for k, cell in enumerate(row):
            at = f"{chr(65 + k)}{number}"
            if isinstance(cell, str):
                cells.append(f'<c r="{at}" t="inlineStr"><is><t>{cell}</t></is></c>')
            elif isinstance(cell, tuple):
                cells.append(f'<c r="{at}" s="1"><v>{cell[1]!r}</v></c>')
            elif cell is not None:
                cells.append(f'<c r="{at}"><v>{cell!r}</v></c>')
        if cells:
            out.append(f'<row r="{number}">{"".join(cells)}</row>')
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<worksheet xmlns="{MAIN}"><sheetData>{"".join(out)}</sheetData></worksheet>'


INFO = [["Campaign 7", "cell B"], ["r1", "is the shoulder"]]
DATA = [
    ["Protocol, hall 3"],
    [],
    ["r1 (°)", "r2 (°)", "slide (mm)", "r4 (°)", "x (mm)", "y (mm)", "z (mm)", "time", "Operator"],
    [10.5, -20.25, 12.5, 90, 1234.5, -0.25, 100, ("date", 45362.34375), "Bert"],
    [11.5, -21.25, 13.5, -90, 1334.5, 0.75, 101.125, ("date", 45362.34444444444), "Bert"],
]

with zipfile.ZipFile("office.xlsx", "w", zipfile.ZIP_DEFLATED) as book:
    for name, text in [
        ("[Content_Types].xml", TYPES),
        ("_rels/.rels", RELATIONS),
        ("xl/workbook.xml", BOOK),
        ("xl/_rels/workbook.xml.rels", BOOK_RELATIONS),
        ("xl/styles.xml", STYLES),
        ("xl/worksheets/sheet1.xml", sheet(INFO)),
        ("xl/worksheets/sheet2.xml", sheet(DATA)),
    ]:
        book.writestr(zipfile.ZipInfo(name, (2024, 3, 11, 8, 15, 0)), text, zipfile.ZIP_DEFLATED)
