//! `truepose completions`: completions for shells, and the manual page.

use crate::args::Completions;
use crate::terminal;

/// The feature that makes them is not in this program.
#[cfg(not(feature = "completions"))]
pub fn write(_: &Completions) -> u8 {
    terminal::error(
        "this program was built without completions and manual page; build it with `--features full`",
    );
    2
}

/// Writes them to standard output.
#[cfg(feature = "completions")]
pub fn write(args: &Completions) -> u8 {
    use crate::args::{Args, CompletionsOf};
    use clap_complete::Shell;
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
