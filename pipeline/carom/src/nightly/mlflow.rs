//! A night as a run of an MLflow server, through its REST interface (MLflow 2 and 3; artifacts through the server's own proxy).

use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};
use ureq::Agent;
use ureq::http::Uri;

use super::night::Night;
use crate::report;

/// The experiment that nights are runs of.
const EXPERIMENT: &str = "carom";
/// Longest wait for an answer.
const PATIENCE: Duration = Duration::from_secs(60);
/// Longest value of a parameter that every version of the server takes.
const LONGEST: usize = 500;
/// Scheme of artifacts that the server itself stores.
const PROXIED: &str = "mlflow-artifacts:";

#[derive(Clone, Debug)]
pub struct Server(String);

impl std::str::FromStr for Server {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let uri: Uri = text.parse().map_err(|error| format!("{error}"))?;
        match (uri.scheme_str(), uri.host()) {
            (Some("http"), Some(_)) => Ok(Self(text.trim_end_matches('/').to_owned())),
            _ => Err("give http://HOST:PORT; where the server has TLS, a proxy beside this program must speak it".into()),
        }
    }
}

/// What the server has of a night.
#[derive(serde::Serialize)]
pub struct Tracked {
    /// The run's id.
    pub run: String,
    pub files: usize,
}

impl Server {
    /// Tells the server what was decided in a folder, with what it was decided by. The text of an error completes "failed to …".
    pub fn track(&self, dir: &Path, night: &Night) -> Result<Tracked, String> {
        let agent = Agent::config_builder().timeout_global(Some(PATIENCE));
        let agent = agent.http_status_as_error(false).build().new_agent();
        let session = Session {
            agent,
            server: &self.0,
        };
        let experiment = session.experiment()?;
        let now = milliseconds();
        let name = night.latest.as_deref().unwrap_or("no version");
        let created = session.post(
            "runs/create",
            &json!({
                "experiment_id": experiment, "start_time": now, "run_name": name,
                "tags": [{ "key": "mlflow.note.content", "value": night.text() }],
            }),
        )?;
        let info = &created["run"]["info"];
        let (Some(run), Some(uri)) = (info["run_id"].as_str(), info["artifact_uri"].as_str())
        else {
            return Err(session.unexpected("runs/create", &created.to_string()));
        };
        let metrics = metrics(dir, night)
            .into_iter()
            .map(|(key, value)| json!({ "key": key, "value": value, "timestamp": now, "step": 0 }));
        let params = parameters(night)
            .into_iter()
            .map(|(key, value)| json!({ "key": key, "value": value }));
        session.post(
            "runs/log-batch",
            &json!({
                "run_id": run,
                "metrics": metrics.collect::<Vec<_>>(),
                "params": params.collect::<Vec<_>>(),
            }),
        )?;
        let files = session.upload(dir, night, uri)?;
        let end = json!({ "run_id": run, "status": "FINISHED", "end_time": milliseconds() });
        session.post("runs/update", &end)?;
        Ok(Tracked {
            run: run.into(),
            files,
        })
    }
}

struct Session<'a> {
    agent: Agent,
    server: &'a str,
}

impl Session<'_> {
    /// The experiment's id; it is made where it is not there.
    fn experiment(&self) -> Result<String, String> {
        let what = "experiments/get-by-name";
        let url = format!(
            "{}/api/2.0/mlflow/{what}?experiment_name={EXPERIMENT}",
            self.server
        );
        let answer = self.agent.get(&url).call();
        let mut answer = answer.map_err(|error| self.unreachable(&error))?;
        let status = answer.status();
        let text = answer.body_mut().read_to_string().unwrap_or_default();
        let said: Value = serde_json::from_str(&text).unwrap_or_default();
        let id = match status.as_u16() {
            200 => said["experiment"]["experiment_id"].clone(),
            404 if said["error_code"] == "RESOURCE_DOES_NOT_EXIST" => {
                let new = json!({ "name": EXPERIMENT });
                self.post("experiments/create", &new)?["experiment_id"].clone()
            }
            _ => return Err(self.unexpected(what, &format!("{status}: {text}"))),
        };
        let id = id.as_str().map(str::to_owned);
        id.ok_or_else(|| self.unexpected(what, &text))
    }

    fn post(&self, what: &str, body: &Value) -> Result<Value, String> {
        let url = format!("{}/api/2.0/mlflow/{what}", self.server);
        let request = self.agent.post(&url).content_type("application/json");
        let answer = request.send(body.to_string());
        let mut answer = answer.map_err(|error| self.unreachable(&error))?;
        let text = answer.body_mut().read_to_string().unwrap_or_default();
        match serde_json::from_str(&text) {
            Ok(said) if answer.status().is_success() => Ok(said),
            _ => Err(self.unexpected(what, &format!("{}: {text}", answer.status()))),
        }
    }

    /// The report, what the night decided and found, and the version in use, each file under its name in the folder.
    fn upload(&self, dir: &Path, night: &Night, uri: &str) -> Result<usize, String> {
        let Some(root) = uri.strip_prefix(PROXIED) else {
            return Err(format!(
                "upload the report: {} keeps artifacts at {uri}, which only its own clients reach; start it with --serve-artifacts",
                self.server
            ));
        };
        let root = root.trim_start_matches('/');
        let mut files: Vec<String> = [
            report::FILE,
            "nightly.json",
            "diagnosis.json",
            "evaluation.json",
        ]
        .map(str::to_owned)
        .into();
        if let Some(version) = &night.latest {
            let folder = format!("versions/{version}");
            let entries = fs::read_dir(dir.join(&folder)).into_iter().flatten();
            let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
            files.extend(names.map(|name| format!("{folder}/{name}")));
        }
        files.sort();
        let mut sent = 0;
        for file in files {
            // Of a night without a version some are not there.
            let Ok(bytes) = fs::read(dir.join(&file)) else {
                continue;
            };
            let url = format!(
                "{}/api/2.0/mlflow-artifacts/artifacts/{root}/{file}",
                self.server
            );
            let answer = self.agent.put(&url).send(&bytes[..]);
            let answer = answer.map_err(|error| self.unreachable(&error))?;
            if !answer.status().is_success() {
                return Err(self.unexpected(&file, &answer.status().to_string()));
            }
            sent += 1;
        }
        Ok(sent)
    }

    fn unreachable(&self, error: &ureq::Error) -> String {
        format!("ask the MLflow server {}: {error}", self.server)
    }

    fn unexpected(&self, what: &str, said: &str) -> String {
        let said: String = said.chars().take(LONGEST).collect();
        format!(
            "ask the MLflow server {} for {what}: it answers {said}",
            self.server
        )
    }
}

/// What was compared, by name.
fn parameters(night: &Night) -> Vec<(&'static str, String)> {
    let name = |version: &Option<String>| version.clone().unwrap_or_else(|| "none".into());
    let missing: Vec<&str> = night.missing.iter().map(|one| one.name.as_str()).collect();
    let status = serde_json::to_value(night.status).unwrap_or_default();
    [
        ("status", status.as_str().unwrap_or_default().to_owned()),
        ("before", name(&night.before)),
        ("latest", name(&night.latest)),
        ("waiting", name(&night.waiting)),
        ("new_logs", night.new_logs.join(", ")),
        ("missing", missing.join(", ")),
        ("why", night.why.join("; ")),
    ]
    .map(|(key, value)| (key, value.chars().take(LONGEST).collect()))
    .into()
}

/// Counts, promises and stop errors (m), the latter by model as in evaluation.json.
fn metrics(dir: &Path, night: &Night) -> Vec<(String, f64)> {
    let mut all: Vec<(String, f64)> = [
        ("logs", Some(night.logs as f64)),
        ("strikes", Some(night.strikes as f64)),
        ("new_strikes", Some(night.new_strikes as f64)),
        ("rejected", Some(night.rejected as f64)),
        ("promised", night.promised),
        ("achieved", night.achieved),
        ("in_use_for_days", night.in_use_for),
    ]
    .into_iter()
    .filter_map(|(key, value)| Some((key.to_owned(), value?)))
    .collect();
    let evaluation = fs::read(dir.join("evaluation.json")).unwrap_or_default();
    let evaluation: Value = serde_json::from_slice(&evaluation).unwrap_or_default();
    for (model, errors) in evaluation.as_object().into_iter().flatten() {
        for (quantity, value) in errors.as_object().into_iter().flatten() {
            all.extend(
                value
                    .as_f64()
                    .map(|value| (format!("{model}/{quantity}"), value)),
            );
        }
    }
    all
}

fn milliseconds() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |now| u64::try_from(now.as_millis()).unwrap_or(u64::MAX))
}
