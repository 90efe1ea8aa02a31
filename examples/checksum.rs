//! `checksum FILE.fray..`: the probe on the host. Prints what `examples/firmware` and `examples/web` print.
use flashray::Scene;
use flashray::blob::Buffer;
use std::error::Error;
use std::process::ExitCode;

mod probe;

fn main() -> ExitCode {
    let paths: Vec<_> = std::env::args().skip(1).collect();
    if paths.is_empty() {
        eprintln!("usage: checksum FILE.fray..");
        return ExitCode::from(2);
    }
    for path in paths {
        println!("file={path}");
        if let Err(error) = print(&path) {
            eprintln!("{path}: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn print(path: &str) -> Result<(), Box<dyn Error>> {
    let blob = Buffer::from(std::fs::read(path)?.as_slice());
    let scene = Scene::from_bytes(&blob)?;
    println!("check=ok");
    let answer = probe::run(&scene, &mut ());
    println!("crc=0x{:08x}\nhits={}", answer.crc, answer.hits);
    Ok(())
}
