//! `truepose export`: the fitted geometry in forms that other controllers take.

use super::{print_json, target, usable_fit};
use crate::args::{self, Export, YamlStyle};
use crate::failure::Failure;
use crate::terminal;
use truepose_compensate::{Accuracy, Comparison, ExportOptions, RosStyle, parameter_table};
use truepose_errormodel::FittedModel;
use truepose_io::{check_writable, write_whole};
use truepose_workflow::{ExportRequest, export, in_session, parameters_csv, parameters_of};

/// Runs the verb.
pub fn run(args: &Export) -> Result<(), Failure> {
    if args.urdf.is_some() && args.format != args::ExportFormat::Urdf {
        return Err(Failure::Input("--urdf: only `--format urdf` corrects a URDF".into()));
    }
    let styled = args.format == args::ExportFormat::RosYaml;
    for (option, given) in
        [("--style", args.style.is_some()), ("--like", args.like.is_some()), ("--hash", args.hash.is_some())]
    {
        if given && !styled {
            return Err(Failure::Input(format!("{option}: only `--format ros-yaml` has it")));
        }
    }
    if args.hash.is_some() && args.style != Some(YamlStyle::Ur) {
        return Err(Failure::Input("--hash: only `--style ur` has a hash".into()));
    }
    check_writable(&args.out)?;
    let fitted = usable_fit(&args.fit, &args.accept)?;
    let fitted = in_session(fitted, args.session.as_deref(), true)?.of_robot();
    let target = target(&fitted, args.target.as_deref())?;
    let options = ExportOptions { target, ..ExportOptions::default() };
    let Some(format) = args.format.of_geometry() else {
        return as_described(args, &fitted, &options);
    };
    let wanted = ExportRequest {
        format,
        urdf: args.urdf.as_deref(),
        hayati: !args.no_hayati,
        entries: args.entries as usize,
        style: args.style.map(RosStyle::from),
        like: args.like.as_deref(),
        hash: args.hash.as_deref(),
    };
    let written = export(&wanted, &fitted, &options)?;
    write_whole(&args.out, written.text.as_bytes())?;
    if args.json {
        let Comparison { nominal, export, model, rows, drawn_from, measured } = written.comparison;
        let rms = |a: Accuracy| serde_json::json!({"aligned_mm": 1e3 * a.aligned, "as_written_mm": 1e3 * a.as_written});
        return print_json(&serde_json::json!({
            "left_out": written.left_out,
            "error_left": {"rms_mm": 1e3 * written.remaining_error.rms, "max_mm": 1e3 * written.remaining_error.max},
            "rms": {
                "nominal": rms(nominal), "export": rms(export), "model": rms(model),
                "rows": rows, "drawn_from": drawn_from, "measured": measured,
            },
        }));
    }
    terminal::print(&format!("written to {}\n", args.out.display()));
    for line in &written.statement[1..] {
        terminal::print(&format!("{line}\n"));
    }
    Ok(())
}

/// The parameters of the robot's own description.
fn as_described(args: &Export, fitted: &FittedModel, options: &ExportOptions) -> Result<(), Failure> {
    let exported = parameter_table(fitted, options)?;
    let summary = parameters_of(fitted, &exported.value, &exported.left_out);
    parameters_csv(&args.out, &summary)?.finish()?;
    if args.json {
        return print_json(&summary);
    }
    terminal::print(&format!("written to {}\n{summary}", args.out.display()));
    for line in exported.statement().iter().skip(1) {
        terminal::print(&format!("{line}\n"));
    }
    Ok(())
}
