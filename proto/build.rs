//! Compiles the `.proto` files without an external compiler and keeps the descriptor set for reflection.

use prost::Message as _;

const FILES: [&str; 6] = [
    "counterpoint/v1/event.proto",
    "counterpoint/v1/jobs.proto",
    "counterpoint/v1/blobs.proto",
    "counterpoint/v1/machines.proto",
    "counterpoint/v1/results.proto",
    "counterpoint/v1/operator.proto",
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for file in FILES {
        println!("cargo::rerun-if-changed={file}");
    }
    let descriptors = protox::compile(FILES, ["."])?;
    let out = std::path::PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("counterpoint.v1.bin"), descriptors.encode_to_vec())?;
    tonic_prost_build::configure()
        .bytes(".counterpoint.v1")
        // The same message has the same bytes.
        .btree_map(".counterpoint.v1")
        .extern_path(".counterpoint.v1.EventBatch", "crate::batch::EventBatch")
        .compile_fds(descriptors)?;
    Ok(())
}
