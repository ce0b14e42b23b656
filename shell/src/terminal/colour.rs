//! Whether colours are written: `--color` says so, or else the environment (`NO_COLOR`,
//! `CLICOLOR_FORCE`, `CLICOLOR`, `TERM`) and whether there is a terminal.

use anstream::stream::RawStream;
use anstream::{AutoStream, ColorChoice};
use std::ffi::OsString;

/// What `--color` asks for, of all commands and of the messages about the command line itself.
pub fn choose(asked: clap::ColorChoice) {
    match asked {
        clap::ColorChoice::Auto => ColorChoice::Auto,
        clap::ColorChoice::Always => ColorChoice::Always,
        clap::ColorChoice::Never => ColorChoice::Never,
    }
    .write_global();
}

/// Whether a stream takes colours.
pub(crate) fn is_taken_by(stream: &impl RawStream) -> bool {
    AutoStream::choice(stream) != ColorChoice::Never
}

/// What the words of a command line that cannot be understood ask for.
pub fn asked_in(words: impl IntoIterator<Item = OsString>) -> clap::ColorChoice {
    let words: Vec<String> =
        words.into_iter().map(|word| word.to_string_lossy().into_owned()).take_while(|word| word != "--").collect();
    let behind = words.windows(2).filter(|pair| pair[0] == OPTION).map(|pair| pair[1].as_str());
    let joined = words.iter().filter_map(|word| word.strip_prefix(OPTION)?.strip_prefix('='));
    let asked = behind.chain(joined).find_map(|word| clap::ValueEnum::from_str(word, false).ok());
    asked.unwrap_or(clap::ColorChoice::Auto)
}

const OPTION: &str = "--color";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_with_faults_says_whether_they_are_coloured() {
        let asked = |line: &str| asked_in(line.split(' ').map(OsString::from));
        assert_eq!(asked("rpl --color always rnu"), clap::ColorChoice::Always);
        assert_eq!(asked("rpl rnu x.rpl --color=never"), clap::ColorChoice::Never);
        assert_eq!(asked("rpl rnu --color"), clap::ColorChoice::Auto);
        assert_eq!(asked("rpl rnu --color sometimes"), clap::ColorChoice::Auto);
        assert_eq!(asked("rpl eval -- --color always"), clap::ColorChoice::Auto);
    }
}
