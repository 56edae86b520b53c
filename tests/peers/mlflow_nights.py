"""Nights told to a real MLflow server: `mlflow_nights.py CAROM FOLDER`. Exits with 1 and says what does not hold."""

import json
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import mlflow
from checking import check, finish

carom, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()


def night(*more):
    line = [carom, "nightly", work / "rig/logs", "--rig", work / "rig/rig.toml", "--out", work / "run", "--json", "--quiet", *more]
    done = subprocess.run(line, capture_output=True, text=True)
    return done.returncode, json.loads(done.stdout), done.stderr


work = folder / "work"
shutil.rmtree(work, ignore_errors=True)
work.mkdir(parents=True)
subprocess.run([carom, "demo", "--strikes", "80", "--seed", "3", "--hide", "none", "--out", work / "rig"], check=True, capture_output=True)

with socket.socket() as probe:
    probe.bind(("127.0.0.1", 0))
    port = probe.getsockname()[1]
uri = f"http://127.0.0.1:{port}"

# Nobody listens yet: the night's work stands.
code, said, _ = night("--mlflow", uri)
check(code in (0, 3) and "failed to ask the MLflow server" in said["mlflow"]["error"], f"no server: exit {code}, {said['mlflow']}")
check((work / "run/latest").read_text().strip() == said["latest"], f"{said['latest']} is in use all the same")
shutil.rmtree(work / "run")

store = ["--backend-store-uri", f"sqlite:///{work}/mlflow.db", "--artifacts-destination", str(work / "stored")]
server = subprocess.Popen([Path(sys.executable).parent / "mlflow", "server", "--host", "127.0.0.1", "--port", str(port), "--workers", "1", *store], cwd=work, stdout=open(work / "server.log", "w"), stderr=subprocess.STDOUT)
try:
    for _ in range(600):
        try:
            urllib.request.urlopen(f"{uri}/health", timeout=5)
            break
        except OSError:
            time.sleep(0.5)
    code, said, errors = night("--mlflow", uri)
    check(code in (0, 3), f"a night: exit {code}, {said.get('mlflow')} {errors}")
    code, again, _ = night("--mlflow", uri)
    check(again["status"] == "nothing_new" and "mlflow" not in again, "a night with nothing to decide is no run")

    client = mlflow.MlflowClient(uri)
    experiment = client.get_experiment_by_name("carom")
    runs = client.search_runs([experiment.experiment_id])
    check(len(runs) == 1 and runs[0].info.run_id == said["mlflow"]["run"], "the server has one run")
    run = runs[0]
    check(run.info.status == "FINISHED" and run.info.run_name == said["latest"], f"{run.info.run_name}, {run.info.status}")
    evaluation = json.loads((work / "run/evaluation.json").read_text())
    check(run.data.metrics["sysid/mean"] == evaluation["sysid"]["mean"], f"metrics: {run.data.metrics}")
    check(run.data.metrics["strikes"] == said["strikes"], "as many strikes")
    check(run.data.params["status"] == said["status"], f"parameters: {run.data.params}")
    mlflow.set_tracking_uri(uri)
    fetched = Path(mlflow.artifacts.download_artifacts(run_id=run.info.run_id, dst_path=str(work / "fetched")))
    files = sorted(str(file.relative_to(fetched)) for file in fetched.rglob("*") if file.is_file())
    check("report.html" in files and f"versions/{said['latest']}/manifest.json" in files, f"files: {files}")
    same = all((fetched / file).read_bytes() == (work / "run" / file).read_bytes() for file in files)
    check(same and len(files) == said["mlflow"]["files"], "each as it is in the run's folder")
finally:
    server.terminate()
    server.wait(30)

refused = subprocess.run([carom, "nightly", "--out", work / "run", "--mlflow", "ftp://here"], capture_output=True, text=True)
check(refused.returncode == 2 and "http://HOST:PORT" in refused.stderr, "an address that is none is refused at once")
finish()
