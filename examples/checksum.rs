//! `checksum FILE.fray`: the probe on the host. Prints what `examples/firmware` and `examples/web` print.
use flashray::Scene;
use flashray::blob::Buffer;
use std::error::Error;
use std::process::ExitCode;

mod probe;

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: checksum FILE.fray");
        return ExitCode::from(2);
    };
    match print(&path) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{path}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn print(path: &str) -> Result<(), Box<dyn Error>> {
    let blob = Buffer::from(std::fs::read(path)?.as_slice());
    let scene = Scene::from_bytes(&blob)?;
    println!("check=ok");
    let answer = probe::run(&scene, &mut ());
    println!("crc=0x{:08x}\nhits={}", answer.crc, answer.hits);
    Ok(())
}
