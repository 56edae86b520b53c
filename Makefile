# Everything that carom needs beside rustup's stable Rust, Python 3 with pip and a C compiler is set up here,
# under .native/. A second run of any target does nothing that is done.
.PHONY: build run test lint setup clean
.DEFAULT_GOAL := build

DEMO := artifacts/demo
BIN := target/debug

setup:
	@sh pipeline/world/native/install.sh .native

build: setup
	cargo build --workspace --locked

# 500 demo strikes, the whole pipeline, and one strike at a target with what came of it.
run: build
	$(BIN)/carom demo --strikes 500 --seed 1 --out $(DEMO)/rig
	$(BIN)/carom run $(DEMO)/rig/logs --rig $(DEMO)/rig/rig.toml --out $(DEMO)
	$(BIN)/strike --artifacts $(DEMO) --from 0.30 0.00 --to 0.62 0.06 --robot sim

lint: setup
	cargo fmt --check
	cargo clippy --workspace --all-targets --locked -- -D warnings

test: lint
	cargo test --workspace --locked

clean:
	cargo clean
	rm -rf .native $(DEMO)
