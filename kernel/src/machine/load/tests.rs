//! Tests of loading.
use super::*;
#[test]
fn shipped_probe() {
    let files = crate::machine::package::shipped();
    for name in
        ["fanuc-common", "fanuc-turning", "fanuc-milling", "fanuc-2path-lathe", "fanuc-3path-lathe", "fanuc-mill"]
    {
        let l = load(&files, name);
        println!("{name} {}", l.machine.is_some());
        for f in &l.findings {
            println!("{f}");
        }
    }
    println!("{:?}", crate::machine::package::shipped_names());
}
