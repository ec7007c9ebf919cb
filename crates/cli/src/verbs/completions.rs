//! `truepose completions`: completions for shells, and the manual page.

use crate::args::{Args, Completions, CompletionsOf};
use crate::terminal;
use clap_complete::Shell;

/// Writes them to standard output.
pub fn write(args: &Completions) -> u8 {
    let mut command = Args::whole();
    let mut text = Vec::new();
    let shell = match args.of {
        CompletionsOf::Bash => Shell::Bash,
        CompletionsOf::Zsh => Shell::Zsh,
        CompletionsOf::Fish => Shell::Fish,
        CompletionsOf::Powershell => Shell::PowerShell,
        CompletionsOf::Elvish => Shell::Elvish,
        CompletionsOf::Man => {
            command.build();
            let mut done = clap_mangen::Man::new(command.clone()).render(&mut text);
            for verb in
                command.get_subcommands().filter(|verb| !verb.is_hide_set() && verb.get_name() != "help")
            {
                let name = format!("truepose-{}", verb.get_name());
                done = done.and_then(|()| clap_mangen::Man::new(verb.clone()).title(name).render(&mut text));
            }
            if done.is_err() {
                return 1;
            }
            terminal::print_bytes(&text);
            return 0;
        }
    };
    clap_complete::generate(shell, &mut command, "truepose", &mut text);
    terminal::print_bytes(&text);
    0
}
