//! Reading a fit file.

use super::schema_v1::FitV1;
use super::{FIT_FORMAT, PROGRAM};
use crate::IoError;
use crate::text::Text;
use serde::Deserialize;
use std::path::Path;
use truepose_errormodel::{EffectRegistry, FittedModel};

/// A covariance of a few thousand coefficients fits in here.
const LARGEST_FIT: u64 = 1 << 30;

/// Heading of a file, in any format.
#[derive(Deserialize)]
struct Heading {
    format: Option<u64>,
    program: Option<String>,
}

/// Reads a fit file; its effects have to be known to the registry.
///
/// # Errors
/// When the file cannot be read, is not a fit file, is of a newer format, or contradicts itself.
pub fn read_fit(path: impl AsRef<Path>, registry: &EffectRegistry) -> Result<FittedModel, IoError> {
    of_text(&Text::read_up_to(path.as_ref(), LARGEST_FIT)?, registry)
}

/// Reads the contents of a fit file that are in memory. Messages name the file `fit`.
///
/// # Errors
/// As [`read_fit`].
pub fn parse_fit(text: &str, registry: &EffectRegistry) -> Result<FittedModel, IoError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    of_text(&Text { file: "fit".into(), text: text.into() }, registry)
}

fn of_text(text: &Text, registry: &EffectRegistry) -> Result<FittedModel, IoError> {
    let path = text.file.as_path();
    if text.text.trim().is_empty() {
        return Err(IoError::file(path, "is empty; a fit file is written by `truepose identify`"));
    }
    let heading: Heading = parsed(text)?;
    match heading.format {
        Some(FIT_FORMAT) => {}
        Some(newer) if newer > FIT_FORMAT => {
            let by = heading.program.unwrap_or_else(|| "a newer version of truepose".into());
            return Err(IoError::file(
                path,
                format!("is of format {newer}, which {PROGRAM} does not read; use {by} or a later version"),
            ));
        }
        Some(other) => {
            return Err(IoError::file(
                path,
                format!("is of format {other}, which does not exist; formats begin with 1"),
            ));
        }
        None => {
            return Err(IoError::file(
                path,
                "is not a fit file: it has no `format`; `truepose identify` writes such files",
            ));
        }
    }
    let file: FitV1 = parsed(text)?;
    file.into_model(registry).map_err(|message| IoError::file(path, message))
}

fn parsed<'t, T: Deserialize<'t>>(text: &'t Text) -> Result<T, IoError> {
    serde_json::from_str(&text.text).map_err(|error| {
        let words = error.to_string();
        let words = words.split(" at line ").next().unwrap_or(&words);
        let message = match error.classify() {
            serde_json::error::Category::Eof => {
                format!("the file ends too early ({words}); it is incomplete")
            }
            _ if !text.text.trim_start().starts_with('{') => {
                "is not a fit file; `truepose identify` writes such files".to_owned()
            }
            serde_json::error::Category::Data => format!("is not a fit file of format {FIT_FORMAT}: {words}"),
            _ => format!("is not JSON: {words}"),
        };
        IoError::Text {
            file: text.file.clone(),
            line: error.line().max(1) as u64,
            column: error.column().max(1) as u64,
            message,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::write::text as fit_json;
    use crate::write_fit;
    use proptest::prelude::*;
    use truepose_errormodel::effects::{Geometric, JointCompliance};
    use truepose_errormodel::{Channel, Dataset, Domain, ErrorModel, Interval, NoiseModel, Sample};
    use truepose_kinematics::nalgebra::{DMatrix, Vector3};
    use truepose_kinematics::{Chain, Load, Payload, Wrench, samples};

    fn fit(chain: Chain, numbers: &mut dyn FnMut() -> f64) -> FittedModel {
        let model = ErrorModel::new(
            chain,
            vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())],
        )
        .unwrap();
        let n = model.columns().len();
        let scales: Vec<f64> = model.columns().iter().map(|column| column.scale).collect();
        // Any bits, of the size of an error.
        let mut sized = || match numbers() {
            v if v.abs() < 1e3 => v,
            v => v / f64::MAX,
        };
        let coefficients = scales.iter().map(|scale| scale * sized()).collect();
        let half = DMatrix::from_fn(n, n, |i, _| scales[i] * sized());
        let whole = &half * half.transpose();
        let covariance = DMatrix::from_fn(n, n, |i, j| whole[(i.max(j), i.min(j))]);
        let mut fit = FittedModel::new(model, coefficients, covariance).unwrap();
        fit.channels = vec![Channel { name: "oil".into(), unit: "degC".into(), temperature: true }];
        fit.noise = NoiseModel { position_sd: 5e-5, ..NoiseModel::none() };
        fit.domain = Domain {
            joints: vec![Interval { lower: -1.0, upper: 2.0 }; fit.chain().movable().len()],
            payload: Some(Interval { lower: 0.0, upper: 70.0 }),
            time: None,
            by_order: false,
            channels: vec![],
            targets: vec![None],
            sample: Sample::of(&rows(fit.chain(), numbers)),
        };
        fit.provenance.insert("data".into(), "train.csv".into());
        fit
    }

    /// Three rows, the second without a height and the third with an orientation alone.
    fn rows(chain: &Chain, numbers: &mut dyn FnMut() -> f64) -> Dataset {
        let n = chain.movable().len();
        let mut columns = |count: usize| (0..count).map(|_| (0..3).map(|_| numbers()).collect()).collect();
        Dataset {
            joints: columns(n),
            approach: columns(n),
            position: vec![[1.0, 2.0, 3.0], [0.1, 0.2, f64::NAN], [f64::NAN; 3]],
            orientation: vec![None, None, Some([1.0, 0.0, 0.0, 0.0])],
            position_sd: vec![[f64::NAN; 3]; 3],
            orientation_sd: vec![[f64::NAN; 3]; 3],
            target: vec![None; 3],
            visit: vec![0, 1, 2],
            load: vec![
                Load::None,
                Load::Payload(Payload { mass: 2.5, com: Vector3::new(0.1, 0.0, 0.3) }),
                Load::Wrench(Wrench { force: Vector3::x(), moment: Vector3::z() }),
            ],
            time: vec![0.0; 3],
            ..Dataset::default()
        }
    }

    fn read(text: &[u8]) -> Result<FittedModel, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fit.json");
        std::fs::write(&path, text).unwrap();
        read_fit(&path, &EffectRegistry::builtin())
            .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        #[test]
        fn fits_come_back_to_the_bit(seed: u64, which in 0usize..6) {
            let mut state = seed;
            let mut numbers = || {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                let value = f64::from_bits(state ^ (state >> 29));
                if value.is_finite() { value } else { -0.0 }
            };
            let chain = samples::all().swap_remove(which);
            let fit = fit(chain, &mut numbers);
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("fit.json");
            write_fit(&path, &fit).unwrap();
            let again = read_fit(&path, &EffectRegistry::builtin()).unwrap();
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(again.chain(), fit.chain());
            prop_assert_eq!(bits(again.coefficients()), bits(fit.coefficients()));
            prop_assert_eq!(bits(again.covariance().as_slice()), bits(fit.covariance().as_slice()));
            prop_assert_eq!((&again.channels, &again.domain, again.noise, &again.provenance),
                (&fit.channels, &fit.domain, fit.noise, &fit.provenance));
            prop_assert_eq!(fit_json(&again).unwrap(), fit_json(&fit).unwrap());
        }
    }

    #[test]
    fn what_is_wrong_is_reported() {
        let good = fit_json(&fit(samples::scara(), &mut || 0.5)).unwrap();
        assert!(read(good.as_bytes()).is_ok());
        let error = |text: &str| read(text.as_bytes()).unwrap_err();
        let with = |from: &str, to: &str| {
            assert!(good.contains(from), "{from}");
            error(&good.replacen(from, to, 1))
        };
        assert_eq!(
            with(
                "\"format\": 1,\n\"program\": \"truepose 0.1.0\"",
                "\"format\": 3,\n\"program\": \"truepose 7.2.0\""
            ),
            "fit.json: is of format 3, which truepose 0.1.0 does not read; use truepose 7.2.0 or a later version"
        );
        assert_eq!(
            with("\"format\": 1", "\"format\": 0"),
            "fit.json: is of format 0, which does not exist; formats begin with 1"
        );
        assert_eq!(
            error("{\"a\": 1}"),
            "fit.json: is not a fit file: it has no `format`; `truepose identify` writes such files"
        );
        assert_eq!(error(""), "fit.json: is empty; a fit file is written by `truepose identify`");
        assert_eq!(error("hello"), "fit.json:1:1: is not a fit file; `truepose identify` writes such files");
        assert_eq!(
            with("geometric", "geometrics"),
            "fit.json: unknown effect family `geometrics`; known families: backlash, base_compliance, coupling, \
             drift, expansion, geometric, guideway, instrument, joint_compliance, landmarks, link_compliance, \
             load_nonlinearity, observed, polynomial, session, shift, thermal, transmission"
        );
        assert_eq!(
            with("x@base", "y@base"),
            "fit.json: coefficient 1 is `y@base` [m], but the model of the file has `x@base` [m] there; the file is damaged"
        );
        assert!(with("\"targets\":[]", "\"targets\":7").starts_with("fit.json:4:"));
        assert!(
            with("\"orientation_sd\":0.0", "\"orientation_sd\":null")
                .contains("is not a fit file of format 1: ")
        );
        assert!(error("[]").starts_with("fit.json:1:"));
        assert!(error(&"[".repeat(100_000)).starts_with("fit.json:1:"));
    }

    /// Every number and name that a person may have put into a fit file, and no fit writes.
    #[test]
    fn a_fit_edited_by_hand_is_refused_with_the_key() {
        let chain = samples::scara();
        let mut made = fit(chain.clone(), &mut || 0.5);
        made.loads = vec![truepose_errormodel::LoadCorrection { declared: 5.0, carried: 6.0, during: None }];
        let good: serde_json::Value = serde_json::from_str(&fit_json(&made).unwrap()).unwrap();
        assert!(read(good.to_string().as_bytes()).is_ok());
        let joint = chain.joint(chain.movable()[0]).name.clone();
        let edits: &[(&str, serde_json::Value, &str)] = &[
            ("/coefficients/3/value", 1e300.into(), "`coefficients[3].value`: `rx@base` is 1e300 rad"),
            ("/coefficients/0/value", (-1e9).into(), "`coefficients[0].value`: "),
            (
                "/covariance/2/2",
                1e300.into(),
                "`covariance[2][2]`: the variance of `z@base` is 1e300, too large",
            ),
            (
                "/covariance/2/2",
                (-1.0).into(),
                "`covariance[2][2]`: the variance of `z@base` is -1e0, below zero",
            ),
            ("/covariance/1/0", 1.0.into(), "`covariance[1][0]` is 1e0, but `covariance[0][1]` is "),
            ("/covariance/0/0", 0.0.into(), "`covariance` is not one: "),
            ("/domain/joints/1", serde_json::json!([2.0, -1.0]), "`domain.joints[1]` is reversed: [2, -1]"),
            ("/domain/joints", serde_json::json!([[0.0, 1.0]]), "`domain.joints` has 1 ranges, not "),
            (
                "/domain/channels",
                serde_json::json!([[0.0, 1.0], [0.0, 1.0]]),
                "`domain.channels` has 2 ranges, not 1",
            ),
            ("/domain/payload", serde_json::json!([9.0, 1.0]), "`domain.payload` is reversed"),
            (
                "/domain/payload",
                serde_json::json!([-9.0, 1.0]),
                "`domain.payload` begins at -9 kg, below zero",
            ),
            ("/loads/0/carried", (-6.0).into(), "`loads[0].carried` is -6 kg, below zero"),
            (
                "/loads",
                serde_json::json!([{"declared": 5.0, "carried": 6.0}, {"declared": 5.0, "carried": 7.0}]),
                "`loads[1].declared`: 5 kg stands twice",
            ),
            ("/channels/0/name", joint.clone().into(), "a channel cannot bear the name of a joint"),
            ("/channels/0/name", "payload".into(), "`channels[0].name`: `payload`: a channel cannot bear"),
            ("/channels/0/name", "".into(), "`channels[0].name`: ``: it has no name"),
            (
                "/channels",
                serde_json::json!([{"name": "oil", "unit": "K", "temperature": true}, {"name": "oil", "unit": "1", "temperature": false}]),
                "`channels[1].name`: `oil`: the name stands twice",
            ),
            (
                "/channels",
                (0..5000)
                    .map(|k| serde_json::json!({"name": format!("c{k}"), "unit": "1", "temperature": false}))
                    .collect(),
                "`channels` has more channels than a table of measurements has columns (4096)",
            ),
            (
                "/robot/joints/0/name",
                "a\nb".into(),
                "`robot.joints[0].name`: the name `a\\nb` cannot be used in a cell",
            ),
            (
                "/robot/joints/0/limits",
                serde_json::json!([1.0, -1.0]),
                "the limits of joint `r1` are the wrong way round",
            ),
            ("/noise/position_sd", (-1.0).into(), "a standard deviation of `noise` is below zero"),
        ];
        for (key, value, words) in edits {
            let mut edited = good.clone();
            *edited.pointer_mut(key).unwrap_or_else(|| panic!("{key}")) = value.clone();
            let message = read(edited.to_string().as_bytes()).expect_err(key);
            assert!(message.starts_with("fit.json: ") && message.contains(words), "{key}: {message}");
        }
        for (key, value, words) in [
            ("payload", serde_json::json!([-1.0, 0.0, 0.0, 0.0]), "].payload` is -1 kg, below zero"),
            ("orientation", serde_json::json!([2.0, 0.0, 0.0, 0.0]), "no unit quaternion"),
        ] {
            let mut edited = good.clone();
            edited["sample"][0][key] = value;
            let message = read(edited.to_string().as_bytes()).expect_err(key);
            assert!(message.starts_with("fit.json: `sample[0]") && message.contains(words), "{message}");
        }
        // What JSON has no number for.
        let text = good.to_string();
        let first = good["coefficients"][0]["value"].to_string();
        for number in ["NaN", "Infinity", "-inf", "1e999"] {
            let edited = text.replacen(&format!("\"value\":{first}"), &format!("\"value\":{number}"), 1);
            assert_ne!(edited, text);
            assert!(read(edited.as_bytes()).unwrap_err().starts_with("fit.json:1:"));
        }
        let mut without = good.clone();
        without.as_object_mut().unwrap().remove("domain");
        assert!(read(without.to_string().as_bytes()).unwrap_err().contains("missing field `domain`"));
    }

    #[test]
    fn a_truncated_file_never_passes() {
        let good = fit_json(&fit(samples::scara(), &mut || 0.25)).unwrap();
        for end in (0..good.trim_end().len()).step_by(97) {
            let message = read(&good.as_bytes()[..end]).expect_err("half a file");
            assert!(message.starts_with("fit.json"), "{message}");
        }
    }

    #[test]
    fn what_is_not_finite_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fit.json");
        let message = write_fit(&path, &fit(samples::scara(), &mut || f64::NAN)).unwrap_err().to_string();
        assert!(message.ends_with(
            "cannot be written: coefficient `x@base` is NaN; a fit file holds finite numbers only"
        ));
        assert!(!path.exists());
    }
}
