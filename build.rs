//! Turns `grammar/pse.lalrpop` into the parser that `src/syntax/parse.rs` includes.

fn main() {
    let out = std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR for build scripts");
    lalrpop::Configuration::new()
        .set_in_dir("grammar")
        .set_out_dir(out)
        .emit_rerun_directives(true)
        .process()
        .expect("grammar/pse.lalrpop is a correct grammar");
}
