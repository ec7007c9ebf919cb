//! Where the files of a program are written.

use super::table_of;
use crate::args::NamedFile;
use crate::failure::Failure;
use std::path::{Path, PathBuf};
use truepose_io::{check_writable, same_file};
use truepose_workflow::program::{RewrittenFile, short};

/// The place of each file: the program's is `out`. A further file with the program's name and another ending (`job.dat` of
/// `job.src`) gets the name of `out` with its own ending, any other its own name in the folder of `out`.
///
/// # Errors
/// When a further file would be written over a file that is read, or two would be written to one place.
pub(super) fn outputs(
    out: &Path,
    files: &[RewrittenFile],
    read: &[NamedFile],
) -> Result<Vec<PathBuf>, Failure> {
    let mut places = vec![out.to_path_buf()];
    let program = files.first().map(|first| first.file.clone()).unwrap_or_default();
    for part in files.iter().skip(1) {
        let place = place(out, &program, &part.file);
        for written in [place.clone(), table_of(&place)] {
            let with = part.file.display();
            if let Some(NamedFile { option, .. }) = read.iter().find(|other| same_file(&written, &other.path))
            {
                return Err(Failure::Input(format!(
                    "--out: points of `{with}` are compensated, too, and `{}`, to which they would be written, is what \
                     {option} reads; write into another folder, as in --out NEW/{}",
                    written.display(),
                    short(out)
                )));
            }
            if places.iter().any(|place| same_file(place, &written) || same_file(table_of(place), &written)) {
                return Err(Failure::Input(format!(
                    "--out: `{}` would be written twice: by `{with}`, and by another file; name another file",
                    written.display()
                )));
            }
            check_writable(&written)?;
        }
        places.push(place);
    }
    Ok(places)
}

fn place(out: &Path, program: &Path, file: &Path) -> PathBuf {
    let stem = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
    match file.extension() {
        Some(ending) if stem(program) == stem(file) && program.extension() != Some(ending) => {
            out.with_extension(ending)
        }
        _ => out.with_file_name(short(file)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_stays_a_pair() {
        let of = |out: &str, file: &str| place(Path::new(out), Path::new("in/job.src"), Path::new(file));
        assert_eq!(of("new.src", "in/job.dat"), Path::new("new.dat"));
        assert_eq!(of("out/new.src", "JOB.DAT"), Path::new("out/new.DAT"));
        assert_eq!(of("out/new.src", "in/home.dat"), Path::new("out/home.dat"));
        assert_eq!(of("new.src", "other/job.src"), Path::new("job.src"));
    }
}
