//! Where Python's loader finds MuJoCo's library: in the `mujoco` package beside this one.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-link-arg-cdylib=-Wl,-rpath,$ORIGIN/../mujoco");
}
