//! What a shell and `man` know of both programs.

use std::fs;
use std::process::{Command, Stdio};

use clap::CommandFactory;

use crate::fixture::{carom, done};

#[test]
fn bash_completes_the_words_of_both_programs() {
    for (program, words, expected) in [
        ("carom", "carom artifacts ro", "rollback"),
        ("carom", "carom run --without", "--without-effects"),
        ("strike", "strike --art", "--artifacts"),
    ] {
        let script = script("bash", program);
        // What bash does when a person presses Tab.
        let asked = format!(
            "{script}\nCOMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))\n\
             _{program} {program} \"${{COMP_WORDS[COMP_CWORD]}}\" \"${{COMP_WORDS[COMP_CWORD-1]}}\"\n\
             printf '%s\\n' \"${{COMPREPLY[@]}}\""
        );
        let answer = Command::new("bash").args(["-c", &asked]).output().unwrap();
        let answer = String::from_utf8_lossy(&answer.stdout);
        assert_eq!(answer.trim(), expected, "{words}");
    }
}

#[test]
fn an_answer_that_cannot_be_written_is_no_success() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full");
    let mut program = Command::new(env!("CARGO_BIN_EXE_carom"));
    program.args(["rig", "init"]).stderr(Stdio::null());
    let status = program.stdout(full.unwrap()).status();
    assert_eq!(status.unwrap().code(), Some(1));
}

#[test]
fn every_shell_is_told_every_command() {
    for shell in ["bash", "zsh", "fish"] {
        let script = script(shell, "carom");
        for command in carom::Cli::command().get_subcommands() {
            assert!(script.contains(command.get_name()), "{shell}: {command}");
        }
        assert!(self::script(shell, "strike").contains("adapt"), "{shell}");
    }
    assert!(script("zsh", "strike").starts_with("#compdef strike"));
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    done(&format!("manual --out {}", folder.path().display()));
    let page = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    for command in carom::Cli::command().get_subcommands() {
        let page = page(&format!("carom-{}.1", command.get_name()));
        assert!(page.contains(".SH SYNOPSIS"), "{command}");
    }
    assert!(page("carom-artifacts-diff.1").contains("runs/monday"));
    assert!(page("strike.1").contains("outside_trained_region"));
}

fn script(shell: &str, program: &str) -> String {
    let said = carom(&format!("completions {shell} --program {program}")).unwrap();
    said.text
}
