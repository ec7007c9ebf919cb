//! Changes of a table of measurements, by rows and columns: a column is its number, from 1, or its name without the unit.

/// Header and rows.
struct Sheet {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// The text after a change; none where the change is unknown.
pub fn changed(text: &str, how: &[&str]) -> Option<String> {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect());
    let mut sheet = Sheet { header: lines.next()?, rows: lines.collect() };
    let number = |word: &str| word.parse::<usize>().ok();
    match *how {
        ["cell", "*", columns, new] => {
            for k in sheet.columns(columns)? {
                sheet.rows.iter_mut().for_each(|row| row[k] = new.into());
            }
        }
        ["cell", line, column, new] => {
            let k = sheet.column(column)?;
            sheet.line(number(line)?)?[k] = new.into();
        }
        ["truncate", line, cells] => sheet.line(number(line)?)?.truncate(number(cells)?),
        ["keep", columns] => {
            let keep = sheet.columns(columns)?;
            sheet.each(|row| *row = keep.iter().map(|&k| row[k].clone()).collect());
        }
        // Values of the rows take turns.
        ["column", header, ref values @ ..] => sheet.push(header, values),
        ["columns", count, header, ref values @ ..] => {
            (0..number(count)?).for_each(|k| sheet.push(&header.replace("{k}", &k.to_string()), values));
        }
        ["rows", count] => sheet.rows.truncate(number(count)?),
        ["pick", rows] => {
            let picked: Option<Vec<usize>> = rows.split(' ').map(number).collect();
            sheet.rows = picked?.into_iter().map(|k| sheet.rows[k - 1].clone()).collect();
        }
        // These columns have the values of those, line by line.
        ["cells", to, of] => {
            let (to, of) = (sheet.columns(to)?, sheet.columns(of)?);
            for row in &mut sheet.rows {
                let old = row.clone();
                to.iter().zip(&of).for_each(|(&k, &from)| row[k] = old[from].clone());
            }
        }
        ["late", rows, columns] => {
            let (rows, old) = (number(rows)?, sheet.rows.clone());
            for k in sheet.columns(columns)? {
                (rows..old.len()).for_each(|at| sheet.rows[at][k] = old[at - rows][k].clone());
            }
        }
        ["scale", columns, by] => {
            let by: f64 = by.parse().ok()?;
            sheet.numbers(columns, |values| values.iter().map(|v| v * by).collect())?;
        }
        ["add", columns, values] => {
            let (values, mut at) =
                (values.split(' ').map(|v| v.parse().ok()).collect::<Option<Vec<f64>>>()?, 0);
            sheet.numbers(columns, |old| {
                at += 1;
                old.iter().map(|v| v + values[(at - 1) % values.len()]).collect()
            })?;
        }
        ["add", columns, value, line] => {
            let (value, line, mut at) = (value.parse::<f64>().ok()?, number(line)?, 1);
            sheet.numbers(columns, |old| {
                at += 1;
                old.iter().map(|v| if at == line { v + value } else { *v }).collect()
            })?;
        }
        // The second one becomes its difference to the first one.
        ["coupled", columns] => sheet.numbers(columns, |v| vec![v[0], v[1] - v[0]])?,
        ["inverse"] => sheet.numbers("x y z qw qx qy qz", |v| {
            let r = rotation(&v[3..]);
            let at = [0, 1, 2].map(|k| -(r[0][k] * v[0] + r[1][k] * v[1] + r[2][k] * v[2]));
            vec![at[0], at[1], at[2], v[3], -v[4], -v[5], -v[6]]
        })?,
        ["rpy" | "vector"] => {
            let angles = if how[0] == "rpy" { rpy } else { vector };
            sheet.numbers("qw qx qy qz", |v| [&angles(&rotation(v))[..], &[0.0]].concat())?;
            let columns = sheet.columns("qw qx qy qz")?;
            let names = ["rx[deg]", "ry[deg]", "rz[deg]"];
            columns.iter().zip(names).for_each(|(&k, name)| sheet.header[k] = name.into());
            sheet.each(|row| drop(row.remove(columns[3])));
        }
        _ => return None,
    }
    let all = std::iter::once(&sheet.header).chain(&sheet.rows);
    Some(all.map(|row| row.join(",") + "\n").collect())
}

impl Sheet {
    fn column(&self, name: &str) -> Option<usize> {
        let named = || self.header.iter().position(|header| header.split('[').next() == Some(name));
        name.parse().map_or_else(|_| named(), |k: usize| Some(k - 1))
    }

    fn columns(&self, names: &str) -> Option<Vec<usize>> {
        names.split(' ').map(|name| self.column(name)).collect()
    }

    /// The header is line 1.
    fn line(&mut self, line: usize) -> Option<&mut Vec<String>> {
        if line == 1 { Some(&mut self.header) } else { self.rows.get_mut(line - 2) }
    }

    fn each(&mut self, change: impl Fn(&mut Vec<String>)) {
        std::iter::once(&mut self.header).chain(&mut self.rows).for_each(change);
    }

    fn push(&mut self, header: &str, values: &[&str]) {
        self.header.push(header.into());
        self.rows.iter_mut().zip(values.iter().cycle()).for_each(|(row, value)| row.push((*value).into()));
    }

    fn numbers(&mut self, names: &str, mut change: impl FnMut(&[f64]) -> Vec<f64>) -> Option<()> {
        let columns = self.columns(names)?;
        for row in &mut self.rows {
            let old: Option<Vec<f64>> = columns.iter().map(|&k| row[k].parse().ok()).collect();
            columns.iter().zip(change(&old?)).for_each(|(&k, new)| row[k] = new.to_string());
        }
        Some(())
    }
}

type Rotation = [[f64; 3]; 3];

fn rotation(q: &[f64]) -> Rotation {
    let [w, x, y, z] = [q[0], q[1], q[2], q[3]];
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Roll, pitch, yaw, degrees.
fn rpy(r: &Rotation) -> [f64; 3] {
    let pitch = (-r[2][0]).clamp(-1.0, 1.0).asin();
    [r[2][1].atan2(r[2][2]), pitch, r[1][0].atan2(r[0][0])].map(f64::to_degrees)
}

/// The rotation vector, degrees.
fn vector(r: &Rotation) -> [f64; 3] {
    let cosine = ((r[0][0] + r[1][1] + r[2][2] - 1.0) / 2.0).clamp(-1.0, 1.0);
    let angle = cosine.acos();
    let axis = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]];
    axis.map(|v| (v * angle / (2.0 * angle.sin())).to_degrees())
}
