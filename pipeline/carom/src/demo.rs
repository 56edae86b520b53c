//! `carom demo` and `carom rig init`.

use std::fs;
use std::io::Write;
use std::path::Path;

use rig::Hidden;
use rig::demo::{Settings, Written, write};
use values::Rig;

use crate::Error;
use crate::args::DemoArgs;

/// Writes the demo's folder.
pub fn demo(args: &DemoArgs) -> Result<Written, Error> {
    is_free(&args.out)?;
    let hidden = match args.hide.as_slice() {
        [] => None,
        flags => Some(Hidden::parse(flags).map_err(Error::input)?),
    };
    let plan = match &args.plan {
        None => None,
        Some(path) => {
            let text = fs::read_to_string(path).map_err(|error| Error::unreadable(path, &error))?;
            Some(rig::parse_plan(&text).map_err(Error::input)?)
        }
    };
    let mut settings = Settings::new(args.object.into(), args.strikes as usize, args.seed, hidden);
    settings.plan = plan;
    settings.log_state = args.state;
    write(&settings, &args.out).map_err(|error| match error {
        rig::RigSimError::File { .. } | rig::RigSimError::Log(_) => Error::failed(error),
        error => Error::input(error),
    })
}

/// A rig file and logs that no demo wrote are a person's own: there is no truth beside them.
fn is_free(out: &Path) -> Result<(), Error> {
    let own = ["rig.toml", "logs"].map(|name| out.join(name));
    let own = own.iter().find(|path| match fs::read_dir(path) {
        Ok(mut logs) => logs.next().is_some(),
        Err(_) => path.exists(),
    });
    match own {
        Some(own) if !out.join("truth.json").exists() => Err(Error::input(format!(
            "write a demo into {}: {} is there, and no finished demo wrote it, for there is no truth.json; name another folder \
             with --out, or move it away",
            out.display(),
            own.display()
        ))),
        _ => Ok(()),
    }
}

/// Writes the commented rig file to a file that is not there yet; without one, gives its text. What is said of it.
pub fn rig_init(out: Option<&Path>) -> Result<String, Error> {
    let Some(path) = out else {
        return Ok(Rig::template().into());
    };
    let mut file = fs::File::create_new(path).map_err(|error| {
        Error::input(format!(
            "write {}: {error}; name a file that is not there yet",
            path.display()
        ))
    })?;
    file.write_all(Rig::template().as_bytes())
        .map_err(Error::failed)?;
    Ok(format!("rig file   {}\n", path.display()))
}
