//! How fast measurements are read: `cargo run --release -p truepose-io --example read_speed [MB]`.
#![allow(clippy::print_stdout)] // an example prints

use std::fmt::Write;
use std::time::Instant;
use truepose_io::{MeasurementsOptions, MeasurementsReader, read_measurements};
use truepose_kinematics::samples;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let megabytes: usize = std::env::args().nth(1).map_or(Ok(200), |text| text.parse())?;
    let chain = samples::ur10();
    let mut text = String::from(
        "j1[rad],j2[rad],j3[rad],j4[rad],j5[rad],j6[rad],x[m],y[m],z[m],qw,qx,qy,qz,visit,time[s],oil[degC]\n",
    );
    let mut k = 0u64;
    while text.len() < megabytes << 20 {
        let value = |n: u64| ((k * 37 + n * 1009).wrapping_mul(2654435761) % 2_000_003) as f64 / 1e6 - 1.0;
        for n in 0..9 {
            write!(text, "{:.7},", value(n))?;
        }
        writeln!(
            text,
            "0.680744445,-0.180835661,-0.684901382,-0.186535683,{k},{:.2},{:.3}",
            k as f64 * 0.5,
            20.0 + value(11)
        )?;
        k += 1;
    }
    let folder = std::env::temp_dir().join("truepose-read-speed");
    std::fs::create_dir_all(&folder)?;
    let path = folder.join("d.csv");
    std::fs::write(&path, &text)?;
    let size = text.len() as f64 / 1e6;
    let options = MeasurementsOptions::default();
    for _ in 0..3 {
        let start = Instant::now();
        let mut reader = MeasurementsReader::open(&path, &chain, &options)?;
        let mut block = truepose_errormodel::Dataset::default();
        let mut rows = 0;
        while reader.read_block(4096, &mut block)? > 0 {
            rows += block.len();
        }
        let seconds = start.elapsed().as_secs_f64();
        println!("blocks: {rows} rows, {size:.0} MB in {seconds:.3} s: {:.0} MB/s", size / seconds);
    }
    let start = Instant::now();
    let (data, ..) = read_measurements(&path, &chain, &options)?;
    let seconds = start.elapsed().as_secs_f64();
    println!("whole:  {} rows in {seconds:.3} s: {:.0} MB/s", data.len(), size / seconds);
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}
