//! What the command line takes: here, so that its manual and its completions are written beside carom's.

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgAction, Parser};
use store::Model;

use crate::Choice;

const EXAMPLES: &str = "\
Examples:
  Plan a strike, move nothing:
    strike --artifacts artifacts/demo --from 0.30 0.00 --to 0.70 0.10
  Strike it in the embedded rig; the log goes to artifacts/demo/strikes/, where the next run may ingest it:
    strike --artifacts artifacts/demo --from 0.30 0.00 --to 0.70 0.10 --robot sim
  Check that the artifact is this robot's own, and use another model:
    strike --artifacts artifacts/demo --rig rig.toml --model sysid --to 0.70 0.10
  Strike only with what the holder of a key signed:
    strike --artifacts artifacts/demo --key carom.pub --rig rig.toml --to 0.70 0.10 --robot sim
  Strike with an xArm7, after a dry-run of the same; none of this is safety-rated:
    strike --artifacts artifacts/demo --key carom.pub --rig rig.toml --from 0.30 0.00 --to 0.70 0.10 --robot xarm:192.168.1.10
  The same where the camera sees the object; the log holds the camera's messages too:
    strike --artifacts artifacts/demo --key carom.pub --rig rig.toml --watch ws://localhost:8765 --to 0.70 0.10 --robot xarm:192.168.1.10
  Follow a table that changes: strike after strike, each plan uses those before it:
    strike --artifacts artifacts/demo --from 0.30 0.00 --to 0.70 0.10 --robot sim --adapt
  Plan many targets, a line {\"from\": [x, y], \"to\": [x, y]} each:
    strike --artifacts artifacts/demo --batch targets.jsonl > plans.jsonl

Exit codes: 0 done; 1 failed; 2 wrong usage or bad input; 3 done, but a line of the batch was refused, the log lies
elsewhere, or the camera did not see the object moved and at rest; 4 refused; 75 busy.
A refusal states its reason: not_finite, off_table, outside_trained_region, unreachable, diverged, speed_limit,
angle_limit, reach, keep_out, obstacle, second_push, turned (a box), residual_too_large, plan_expired, malformed (a line of
a batch), not_ready (the robot), other_rig (the artifact was made for another object or striker), not_trusted (not signed by
the key, or older than what was loaded before), table_changed (recent strikes show another table). No command is ever moved into a limit. A damaged artifact is bad input: exit
code 2. With --json every outcome is one object: a plan, a refusal, or {\"failed\": text}; a strike that was made is reported
and its log is kept even where something failed after it.";

fn seconds(text: &str) -> Result<f64, String> {
    let number: f64 = text
        .parse()
        .map_err(|_| "no number of seconds".to_owned())?;
    let is_pause = (0.0..=600.0).contains(&number);
    is_pause
        .then_some(number)
        .ok_or_else(|| "must be 0 to 600 s".into())
}

/// Strikes an object so that it comes to rest at a target.
#[derive(Debug, Parser)]
#[command(name = "strike", disable_version_flag = true, after_help = EXAMPLES)]
pub struct Args {
    /// Folder of a run, or a copy of its `versions/` and `latest`; or a URL (s3://, gs://, az://), of which a verified copy is kept here and used
    /// where the store cannot be reached
    #[arg(long, value_name = "DIR")]
    pub artifacts: PathBuf,
    /// Version to use in place of the latest; alone, without a value, it prints the version of this program
    #[arg(long, value_name = "vNNNN")]
    pub version: Option<String>,
    /// This robot's own rig file. Refuses unless the artifact was made for the same object and striker. Its table and arm's limits
    /// may be stricter than the artifact's, and then hold
    #[arg(long, value_name = "FILE")]
    pub rig: Option<PathBuf>,
    /// Public key, in minisign's format: refuses versions that it did not sign, or older ones than were loaded before
    /// [default: as strike.toml beside this program says]
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Where the newest version loaded is kept [default: beside the key, ending in .seen]
    #[arg(long, value_name = "FILE")]
    pub seen: Option<PathBuf>,
    /// What this robot trusts: key, rig, seen [default: strike.toml beside this program]
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Model: nominal, sysid, sysid_residual, effect, effect_residual [default: the artifact's best]
    #[arg(long, value_name = "MODEL")]
    pub model: Option<Model>,
    /// Where the object shall come to rest, in m
    #[arg(long, action = ArgAction::Set, num_args = 2, value_names = ["X", "Y"], allow_negative_numbers = true)]
    pub to: Option<Vec<f64>>,
    /// Where the object rests, in m [default: so that its path is the middle of the trained ones; an arm needs it, or --watch]
    #[arg(long, action = ArgAction::Set, num_args = 2, value_names = ["X", "Y"], allow_negative_numbers = true, requires = "to")]
    pub from: Option<Vec<f64>>,
    /// Live topics of the camera (ROS 2's foxglove_bridge, or any server of Foxglove's SDK): they give the object's place at rest, and
    /// are recorded in the log until it rests again
    #[arg(long, value_name = "ws://HOST:PORT", requires = "to", conflicts_with_all = ["from", "batch"])]
    pub watch: Option<String>,
    /// Yaw of a box relative to the table's axes, in rad
    #[arg(
        long,
        value_name = "RAD",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub yaw: f64,
    /// Robot: dry-run, sim (in builds with the embedded rig: the rig whose truth.json lies in DIR or DIR/rig, else the demo's), sim:FOLDER (the one of
    /// FOLDER's), xarm:HOST (UFACTORY's xArm5, 6, 7 and Lite6), ur:HOST (Universal Robots' e-Series); an arm needs --key and --rig
    #[arg(long, value_name = "ROBOT", default_value = "dry-run")]
    pub robot: Choice,
    /// Whoever is told to step back has so long, in s, before an arm moves [default: 0 where standard error is a terminal, whose reader
    /// called it, else 3]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub pause: Option<f64>,
    /// Log of the strike [default: the next strike_NNNNNN.mcap in DIR/strikes]; never overwrites
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Session to plan for, by its log's name, which the version must know; the embedded rig strikes in it [default: a session that
    /// the version has never seen]
    #[arg(long, value_name = "NAME", conflicts_with = "recent")]
    pub session: Option<String>,
    /// Logs of this table's last strikes, in any order: friction, launch speed and heading are followed through them, and plans use
    /// them. Refuses where the table is farther from the version's own than that believes possible
    #[arg(long, value_name = "LOG", num_args = 1..)]
    pub recent: Vec<PathBuf>,
    /// The same by itself, with the logs of the strikes made here since this version learnt; what it knows is kept beside them
    #[arg(long, conflicts_with_all = ["recent", "session"])]
    pub adapt: bool,
    /// File of targets, a JSON object a line, or `-` for standard input: plans for each, no strike
    #[arg(long, value_name = "FILE", conflicts_with_all = ["to", "from", "robot", "log"])]
    pub batch: Option<PathBuf>,
    /// Answer with one JSON object; a batch always answers with one a line
    #[arg(long)]
    pub json: bool,
    /// Print results and errors only
    #[arg(long)]
    pub quiet: bool,
}

impl Args {
    /// How long whoever is told to step back has for it.
    pub fn pause(&self) -> Duration {
        /// Of somebody who did not call it.
        const STEP_BACK: f64 = 3.0;
        let usual = || match io::stderr().is_terminal() || !self.robot.moves() {
            true => 0.0,
            false => STEP_BACK,
        };
        Duration::from_secs_f64(self.pause.unwrap_or_else(usual))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_to_step_back_is_what_is_given_and_none_where_nothing_moves() {
        let parsed = |more: &[&str]| {
            let words = ["strike", "--artifacts", "run", "--to", "0.6", "0.1"];
            Args::try_parse_from([&words[..], more].concat())
        };
        let pause = |more: &[&str]| parsed(more).expect("sound").pause().as_secs_f64();
        assert_eq!(pause(&[]), 0.0);
        assert_eq!(pause(&["--robot", "ur:arm", "--pause", "1.5"]), 1.5);
        assert_eq!(pause(&["--robot", "ur:arm", "--pause", "0"]), 0.0);
        for wrong in ["601", "nan", "soon"] {
            assert!(parsed(&["--pause", wrong]).is_err(), "{wrong}");
        }
    }
}
