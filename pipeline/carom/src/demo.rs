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
