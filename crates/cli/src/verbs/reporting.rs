//! Writing a report's folder: page, figures, the result and what makes the run repeatable.

use crate::args::{Input, OutputFolder};
use crate::failure::Failure;
use crate::terminal;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use truepose_io::{WholeFiles, check_writable, file_digest, make_folder, read_details, sha256};
use truepose_report::{FileRecord, Report, RunRecord};
pub use truepose_workflow::PROGRAM;

/// A folder that a report will be written into.
pub struct Folder {
    path: PathBuf,
    result: &'static str,
    certificate: Option<Vec<(String, String)>>,
}

impl Folder {
    /// Makes it and sees that files can be written there, before long work begins.
    pub fn prepare(path: Option<&OutputFolder>, result: &'static str) -> Result<Option<Self>, Failure> {
        let Some(path) = path else { return Ok(None) };
        make_folder(path)?;
        for file in [result, "index.html", "summary.html", "run.json"] {
            check_writable(path.join(file))?;
        }
        Ok(Some(Folder { path: path.to_path_buf(), result, certificate: None }))
    }

    /// [`Folder::prepare`], with the head of the report of a file.
    pub fn with_head(
        path: Option<&OutputFolder>,
        result: &'static str,
        certificate: Option<&Input>,
    ) -> Result<Option<Self>, Failure> {
        let Some(folder) = Folder::prepare(path, result)? else { return Ok(None) };
        let own = certificate.map(read_details).transpose()?.and_then(|details| details.certificate);
        Ok(Some(Folder { certificate: own.map(|of| of.entries), ..folder }))
    }

    /// With the head of the report of the file of `--certificate`, which has to have one.
    pub fn certified(self, file: Option<&Input>) -> Result<Self, Failure> {
        let Some(file) = file else { return Ok(self) };
        let Some(certificate) = read_details(file)?.certificate else {
            return Err(Failure::Input(format!(
                "--certificate: {} has no table [certificate]",
                file.display()
            )));
        };
        Ok(Folder { certificate: Some(certificate.entries), ..self })
    }

    /// The file of the result.
    pub fn result(&self) -> PathBuf {
        self.path.join(self.result)
    }

    /// Adds the result, the record of the run, and the page that `page` makes of the record, to the files of the run.
    pub fn add(
        &self,
        files: &mut WholeFiles,
        result: &impl serde::Serialize,
        inputs: &[&Path],
        page: impl FnOnce(&RunRecord) -> Result<Report, Failure>,
    ) -> Result<(), Failure> {
        let bytes = (serde_json::to_string_pretty(result)? + "\n").into_bytes();
        let inputs = inputs
            .iter()
            .map(|file| {
                // The content of a pipe cannot be read again.
                let (bytes, sha256) = if file.is_file() { file_digest(file)? } else { (0, String::new()) };
                if sha256.is_empty() {
                    unrepeatable(file, "is not a regular file");
                }
                Ok(FileRecord { file: file.to_string_lossy().into_owned(), bytes, sha256 })
            })
            .collect::<Result<Vec<_>, Failure>>()?;
        let arguments: Vec<OsString> = crate::typed::arguments().into_iter().skip(1).collect();
        if let Some(name) = arguments.iter().find(|argument| argument.to_str().is_none()) {
            unrepeatable(Path::new(name), "is not UTF-8");
        }
        let arguments = arguments.iter().map(|argument| argument.to_string_lossy().into_owned()).collect();
        let record =
            FileRecord { file: self.result.into(), bytes: bytes.len() as u64, sha256: sha256(&bytes) };
        let certificate = self.certificate.clone();
        let run = RunRecord { certificate, ..RunRecord::new(PROGRAM, arguments, inputs, record) };
        let report = page(&run)?;
        files.add(self.path.join(self.result), &bytes)?;
        for (name, svg) in &report.figures {
            files.add(self.path.join(name), svg.as_bytes())?;
        }
        files.add(self.path.join("run.json"), (serde_json::to_string_pretty(&run)? + "\n").as_bytes())?;
        if !report.summary.is_empty() {
            files.add(self.path.join("summary.html"), report.summary.as_bytes())?;
        }
        files.add(self.path.join("index.html"), report.html.as_bytes())?;
        Ok(())
    }

    /// Its page.
    pub fn page(&self) -> PathBuf {
        self.path.join("index.html")
    }
}

/// Warns that `verify` cannot repeat the run.
fn unrepeatable(name: &Path, why: &str) {
    let name = name.display();
    terminal::log(&format!("warning: `{name}` {why}: `truepose verify` cannot repeat this run"));
}
