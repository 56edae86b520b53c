//! `carom`: the pipeline's command line.

use std::process::ExitCode;

/// Has glibc give blocks from 2 MB on back as they are freed: else it keeps as many of them as it has once freed at a time, tens of MB of images
/// and messages.
#[cfg(target_env = "gnu")]
#[expect(unsafe_code, reason = "a call of the C library")]
fn give_memory_back() {
    const LARGE: libc::c_int = 2 << 20;
    // SAFETY: it sets numbers of the allocator, before there is another thread. Where it fails, all goes on as it would.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
        libc::mallopt(libc::M_TRIM_THRESHOLD, LARGE);
    }
}

#[cfg(not(target_env = "gnu"))]
fn give_memory_back() {}

fn main() -> ExitCode {
    give_memory_back();
    if let Err(error) = strike::unblock_signals() {
        strike::tell(&format!("carom: failed to unblock signals: {error}"));
        return ExitCode::FAILURE;
    }
    carom::program(std::env::args_os(), option_env!("CAROM_COMMIT")).into()
}
