# Everything that carom needs beside rustup's stable Rust, Python 3 with pip and a C compiler is set up here,
# under .native/. A second run of any target does nothing that is done.
.PHONY: build install stranger report viewers lerobot run test quick lint wheel dist programs foreign tracked blind kuka first-day curve bench pages fuzz arm loop living soak cluster setup clean
.DEFAULT_GOAL := build

DEMO := artifacts/demo
BIN := target/debug

# What `--version` says of a build.
export CAROM_COMMIT := $(shell git describe --always --dirty --abbrev=12 --exclude='*' 2>/dev/null)

setup:
	@sh artifacts/world/native/install.sh .native
	@sh artifacts/world/native/moved.sh target

build: setup
	cargo build --workspace --locked

# Both programs as commands, with MuJoCo's library beside them: PREFIX/bin links to PREFIX/lib/carom.
PREFIX := $(HOME)/.local
install: build
	install -d "$(DESTDIR)$(PREFIX)/bin" "$(DESTDIR)$(PREFIX)/lib/carom"
	install -m 755 $(BIN)/carom $(BIN)/strike "$(DESTDIR)$(PREFIX)/lib/carom"
	install -m 644 .native/lib/libmujoco.so.3.17.0 "$(DESTDIR)$(PREFIX)/lib/carom"
	ln -sf ../lib/carom/carom ../lib/carom/strike "$(DESTDIR)$(PREFIX)/bin"
	$(BIN)/carom manual --out "$(DESTDIR)$(PREFIX)/share/man/man1"

# What is shipped, in dist/: small, for this machine's architecture and glibc 2.31 and later (Ubuntu 20.04, JetPack 5), linked by zig. It
# compiles everything a second time: half an hour on two cores. `make dist TARGET=aarch64-unknown-linux-gnu` (and `make wheel` alike) is for
# a Jetson or a Raspberry Pi: what it makes is tried under Debian's QEMU, programs with the glibc of Debian 11, on a run of the demo, the package
# with the Python of Debian 12.
HOST := $(shell uname -m)-unknown-linux-gnu
TARGET := $(HOST)
MACHINE := $(firstword $(subst -, ,$(TARGET)))
IS_FOREIGN := $(filter-out $(HOST),$(TARGET))
GLIBC := 2.31
SHIPPED := artifacts/runs/dist
TOOLS := $(SHIPPED)/tools
WITH_TOOLS = PATH="$(CURDIR)/$(TOOLS)/bin:$$PATH"
$(TOOLS)/done: pipeline/dist/requirements.txt
	python3 -m venv $(TOOLS)
	$(TOOLS)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
# The package, which maturin links, is compiled with carom: both have the same dependencies. `strike` has neither the embedded rig nor SQLite.
# Object stores (`s3://` and the like) are 4 MB of each program: with `make dist URLS=1` alone.
COMMA := ,
FOREIGN := $(SHIPPED)/$(MACHINE)
LIBRARY := $(if $(IS_FOREIGN),$(FOREIGN)/native,.native)/lib
EMULATOR := $(if $(IS_FOREIGN),$(FOREIGN)/emulator/run)
WITH_LIBRARY = $(if $(IS_FOREIGN),MUJOCO_DYNAMIC_LINK_DIR="$(CURDIR)/$(LIBRARY)")
# Calls within a program are direct, in place of one address and one relocation for each function; the linker still makes all of them read-only.
SMALLER = CARGO_BUILD_RUSTFLAGS="-C relro-level=partial -C link-arg=-Wl,-z,relro,-z,now"
ZIGBUILD = $(WITH_TOOLS) $(WITH_LIBRARY) $(SMALLER) cargo zigbuild --locked --profile dist --target $(TARGET).$(GLIBC)
foreign:
	rustup --quiet target add $(TARGET)
	sh artifacts/world/native/install.sh $(FOREIGN)/native $(MACHINE)
	sh pipeline/dist/emulator.sh $(FOREIGN)/emulator $(MACHINE) bullseye libc6 libstdc++6
	@test -e $(DEMO)/latest || $(MAKE) run
programs: setup $(TOOLS)/done $(if $(IS_FOREIGN),build foreign)
	$(ZIGBUILD) --package carom --package carom-python --no-default-features --features carom-python/extension$(if $(URLS),$(COMMA)carom/url) --bin carom
	$(ZIGBUILD) --package strike --no-default-features $(if $(URLS),--features url)
	$(TOOLS)/bin/python pipeline/dist/notices.py $(TARGET) > $(SHIPPED)/NOTICES

# An archive of both programs, MuJoCo's library, completions, manual pages and notices; tried in an empty folder with an empty PATH.
dist: programs
	python3 pipeline/dist/archive.py target/$(TARGET)/dist $(LIBRARY)/libmujoco.so.3.17.0 $(SHIPPED)/NOTICES $(TARGET) dist \
		$(if $(IS_FOREIGN),$(EMULATOR) $(DEMO) $(BIN))

# The Python package with both programs inside, installed into an empty environment; its tests and its notebook run there with an empty
# PATH. The notebook with its pictures is left in $(SHIPPED). Of another architecture the package is tried under QEMU, which starts no other program:
# without the tests that do, and without GLFW, which asks another Python for its version.
wheel: programs
	install -D target/$(TARGET)/dist/strike pipeline/python/carom/bin/strike
	install -m 644 $(SHIPPED)/NOTICES pipeline/python/carom
	mkdir -p dist
	rm -rf dist/*_$(MACHINE).whl $(SHIPPED)/empty
	cd pipeline/python && $(WITH_TOOLS) $(WITH_LIBRARY) $(SMALLER) CARGO="$(CURDIR)/pipeline/dist/cargo.sh" CAROM_TARGET=$(TARGET) CAROM_GLIBC=$(GLIBC) \
		maturin build --locked --target $(TARGET) --compatibility manylinux_$(subst .,_,$(GLIBC)) --out $(CURDIR)/dist
	python3 pipeline/dist/wheel.py dist/carom-*_$(MACHINE).whl
ifeq ($(IS_FOREIGN),)
	python3 -m venv $(SHIPPED)/empty
	$(SHIPPED)/empty/bin/python -m pip install --quiet --disable-pip-version-check dist/carom-*_$(MACHINE).whl --requirement pipeline/python/tests/requirements.txt
	cd $(SHIPPED)/empty && env -i PATH= HOME="$(CURDIR)/$(SHIPPED)/empty" CAROM_NOTEBOOK="$(CURDIR)/$(SHIPPED)" \
		bin/python -m pytest -q -p no:cacheprovider "$(CURDIR)/pipeline/python/tests"
else
	sh pipeline/dist/emulator.sh $(FOREIGN)/python $(MACHINE) bookworm python3 libstdc++6
	rm -rf $(FOREIGN)/empty
	$(TOOLS)/bin/python -m pip install --quiet --disable-pip-version-check --target $(FOREIGN)/empty --only-binary :all: --python-version 3.11 \
		$(foreach tag,manylinux_2_31 manylinux_2_28 manylinux2014,--platform $(tag)_$(MACHINE)) \
		dist/carom-*_$(MACHINE).whl --requirement pipeline/python/tests/requirements.txt
	cd $(FOREIGN)/empty && env -i PATH= MUJOCO_GL=disable HOME="$(CURDIR)/$(FOREIGN)/empty" PYTHONPATH="$(CURDIR)/$(FOREIGN)/empty" \
		../python/run ../python/root/usr/bin/python3 -m pytest -q -p no:cacheprovider -k "not programs_do and not programs_run and not stubs" "$(CURDIR)/pipeline/python/tests/test_carom.py"
endif

# README's first commands in two fresh Debians, with what `make wheel` and `make dist` made, and the page that is committed: some two minutes. Needs
# root and debootstrap.
stranger:
	python3 tests/peers/stranger.py artifacts/runs/stranger dist/carom-*_$(MACHINE).whl dist/carom-*-$(TARGET).tar.gz tests/STRANGER.md

# 500 demo strikes, the whole pipeline, and one strike at a target with what came of it.
run: build
	$(BIN)/carom demo --strikes 500 --seed 1 --out $(DEMO)/rig
	$(BIN)/carom run $(DEMO)/rig/logs --rig $(DEMO)/rig/rig.toml --out $(DEMO)
	$(BIN)/strike --artifacts $(DEMO) --from 0.30 0.00 --to 0.62 0.06 --robot sim

# The report of `make run` in a real browser: every plot, wide, narrow, dark and on paper; pictures are left beside it.
CHROMIUM := chromium
BROWSER := artifacts/runs/report/browser
$(BROWSER)/done: tests/peers/requirements_report.txt
	python3 -m venv $(BROWSER)
	$(BROWSER)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
report: $(BROWSER)/done
	@test -e $(DEMO)/report.html || $(MAKE) run
	$(BROWSER)/bin/python tests/peers/report.py $(DEMO)/report.html "$$(command -v $(CHROMIUM))" artifacts/runs/report pipeline/carom/docs/report.png

# What Foxglove's schemas hold and Rerun draws of the demo; its files and a picture are left in $(VIEWERS).
VIEWERS := artifacts/runs/viewers
$(VIEWERS)/python/done: tests/peers/requirements_viewers.txt
	python3 -m venv $(VIEWERS)/python
	$(VIEWERS)/python/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
viewers: build $(VIEWERS)/python/done
	@test -e $(DEMO)/report.html || $(MAKE) run
	$(VIEWERS)/python/bin/python tests/peers/viewers.py $(BIN)/carom $(DEMO) $(VIEWERS) $(VIEWERS)/python/bin

# The demo's strikes as LeRobot's own code reads them.
LEROBOT := artifacts/runs/lerobot
$(LEROBOT)/python/done: tests/peers/requirements_lerobot.txt
	python3 -m venv $(LEROBOT)/python
	$(LEROBOT)/python/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	$(LEROBOT)/python/bin/python -m pip install --quiet --disable-pip-version-check --no-deps lerobot==0.4.4
	touch $@
lerobot: build $(LEROBOT)/python/done
	@test -e $(DEMO)/report.html || $(MAKE) run
	$(LEROBOT)/python/bin/python tests/peers/lerobot_dataset.py $(BIN)/carom $(DEMO) $(LEROBOT)

# Nights as runs of a real MLflow server.
MLFLOW := artifacts/runs/mlflow
$(MLFLOW)/python/done: tests/peers/requirements_mlflow.txt
	python3 -m venv $(MLFLOW)/python
	$(MLFLOW)/python/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
tracked: build $(MLFLOW)/python/done
	$(MLFLOW)/python/bin/python tests/peers/mlflow_nights.py $(BIN)/carom $(MLFLOW)

lint: setup
	cargo fmt --check
	cargo clippy --workspace --all-targets --locked -- -D warnings

# The tests of the emulated arms wait for an arm that moves as fast as one: they run beside the others. No example in a doc comment is a test.
test: lint
	cargo test --workspace --locked --all-targets --no-run
	@cargo test --workspace --locked --test arm > target/arm.log 2>&1 & arm=$$!; \
	cargo test --workspace --locked --all-targets --exclude arm; others=$$?; \
	wait $$arm; arm=$$?; cat target/arm.log; exit $$((others | arm))

# What a change needs while it is made: lint, the structure, and the tests of the crates that differ from where this branch left BASE.
BASE := main
quick: lint
	python3 tests/quick.py $(BASE)

# The hidden-effect benchmark: every effect at four magnitudes, pairs, controls, effects that no candidate has, a box; peers on the
# same sets, and strikes chosen against strikes at random. `make blind HARD=1`: sets drawn at random from noise, forms and phenomena
# that the library was not written for. Both resume where they stopped, and write the page that is committed; take a FIRST that no
# page has had (tests/judged.json lists them). With ONLY=control (single, weak, several, foreign, place, order, odd) sets of one kind are
# made, and the page is printed.
SEEDS := 2
SETS := 400
FIRST := 40000
HARD :=
ONLY :=
REGRESSION := artifacts/runs/blind/peers
$(REGRESSION)/done: tests/peers/requirements_sindy.txt
	python3 -m venv $(REGRESSION)
	$(REGRESSION)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
blind: build $(if $(HARD),,$(REGRESSION)/done)
ifdef HARD
	$(BIN)/blind --hard --sets $(SETS) --first $(FIRST) --only "$(ONLY)" --outcomes artifacts/runs/blind/hard_from_$(FIRST).jsonl $(if $(ONLY),,--page tests/HARD.md)
else
	$(BIN)/blind --seeds $(SEEDS) --first $(FIRST) --outcomes artifacts/runs/blind/from_$(FIRST).jsonl \
		--page tests/BLIND.md --peers $(REGRESSION)/bin/python --chosen
endif

# The real strikes beside this checkout, and the page of what was found in them.
kuka: build
	$(BIN)/kuka

# Twelve mistakes of a first day on eight rigs, logs as they should be, and the page that is committed: some minutes.
first-day: build
	$(BIN)/first-day --page tests/FIRST_DAY.md

# Stop errors by the number of strikes learnt from, and the page that is committed: some minutes.
curve: build
	python3 tests/learning_curve.py --carom $(BIN)/carom

# Carom beside its peers, and the page that is committed: an hour on two idle cores. `make bench PARTS="solve step"` measures
# these anew, `SMALL=1` tries the harness in minutes.
PEERS := artifacts/runs/bench/peers
PARTS :=
SMALL :=
$(PEERS)/done: tests/peers/requirements.txt
	python3 -m venv $(PEERS)
	$(PEERS)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
# Tracking has a page and a peer of its own: `make bench PARTS=track`; `TRACK="speed memory"` measures these of its parts anew.
TRACK :=
OPENCV := artifacts/runs/bench/opencv
$(OPENCV)/done: tests/peers/requirements_track.txt
	python3 -m venv $(OPENCV)
	$(OPENCV)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
bench: build $(if $(filter track,$(PARTS)),$(OPENCV)/done) $(if $(filter-out track,$(PARTS))$(if $(PARTS),,all),$(PEERS)/done)
	$(if $(filter track,$(PARTS)),cargo build --workspace --locked --example frames)
	$(if $(filter track,$(PARTS)),$(OPENCV)/bin/python tests/peers/track.py $(if $(SMALL),--small) $(TRACK))
	$(if $(filter-out track,$(PARTS))$(if $(PARTS),,all),$(PEERS)/bin/python tests/peers/bench.py $(if $(SMALL),--small) $(filter-out track,$(PARTS)))

# Which pages are older than what they measure, by the history of the crates.
pages:
	@python3 tests/pages.py

# Ten minutes of changed inputs for everything that is read from outside, side by side.
FUZZ_SECONDS := 600
FUZZ_SEED := 1
fuzz: build
	@for target in mcap cdr json protobuf image rig world manifest weights segmenter batch live signature; do \
		nice -n 19 $(BIN)/fuzz $$target --seconds $(FUZZ_SECONDS) --seed $(FUZZ_SEED) & pids="$$pids $$!"; \
	done; for pid in $$pids; do wait $$pid || exit 1; done

# The emulated Universal Robots arm read by ur-rtde; the emulated xArm7 under the maker's own SDK, whose bytes for each call are compared with those that the driver's tests hold; live
# topics of Foxglove's own SDK; a collection that signals end; then every fault at every step of a strike, and the page that is
# committed. Ports 502, 29999 to 30004 and 8765 of 127.0.0.1 are taken: 502 needs root.
XARM := artifacts/runs/arm/sdk
FOXGLOVE := artifacts/runs/arm/foxglove
$(XARM)/done: tests/peers/requirements_xarm.txt
	python3 -m venv $(XARM)
	$(XARM)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
arm: build $(XARM)/done
	$(XARM)/bin/python tests/peers/arm.py $(BIN)/arm-emulator tests/arm/tests/sdk_frames.txt --check
	$(XARM)/bin/python tests/peers/ur.py $(BIN)/arm-emulator
	cargo build --locked --manifest-path tests/peers/foxglove_server/Cargo.toml --target-dir $(FOXGLOVE)
	$(XARM)/bin/python tests/peers/watch.py $(BIN)/arm-watch $(FOXGLOVE)/debug/foxglove-server
	$(XARM)/bin/python tests/peers/collect.py xarm $(BIN)/arm-emulator $(BIN)/carom artifacts/runs/arm/collect
	$(XARM)/bin/python tests/peers/collect.py ur $(BIN)/arm-emulator $(BIN)/carom artifacts/runs/arm/collect_ur
	ARM_PAGE=$(CURDIR)/tests/ARM.md cargo test --workspace --locked --test arm -- --nocapture --test-threads 1

# The paper's script on the emulated arms of both makers: collect 100 strikes, run, publish signed, strike 200 targets; three quarters of an hour each,
# for an arm moves as fast as one. It goes on where it was ended; the pages are those that are committed. The same ports as above are taken, and 8765.
loop: build
	$(BIN)/arm-loop xarm artifacts/runs/loop $(BIN) tests/LOOP.md
	$(BIN)/arm-loop ur artifacts/runs/loop_ur $(BIN) tests/LOOP_UR.md

# Tables that change, in the closed loop, beside peers, and the page that is committed: some two minutes a rig. It goes on where it was ended.
RIGS := 30
living: build
	mkdir -p artifacts/runs
	$(BIN)/living --rigs $(RIGS) --outcomes artifacts/runs/living.jsonl --page tests/LIVING.md

# A hundred nights on growing data, a fault in each: some twenty minutes.
soak: build
	nice -n 19 $(BIN)/soak --nights 100 --strikes 2 --seed 7

# Shards, 200 kills, a real Slurm (Debian's packages, unpacked below and not installed), Kubernetes' schema, moto's S3 behind a proxy of faults, and the page that is committed: some
# half an hour. `make cluster SMALL=1` tries it in minutes, `PARTS="kills slurm"` a part of it, `STRIKES=1000` fewer. What it starts it ends.
CLUSTER := artifacts/runs/cluster
STRIKES := 5000
$(CLUSTER)/python/done: tests/peers/requirements_cluster.txt
	python3 -m venv $(CLUSTER)/python
	$(CLUSTER)/python/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@
cluster: build $(CLUSTER)/python/done
	$(CLUSTER)/python/bin/python tests/peers/cluster.py $(BIN)/carom $(CLUSTER)/work tests/CLUSTER.md --strikes $(STRIKES) $(if $(SMALL),--small) $(PARTS)

clean:
	cargo clean
	rm -rf .native $(DEMO)
