//! What is wrong with a text that is no TOML, in words for people who have not learned TOML: the words of a parser say
//! what it expects of grammar.

use std::ops::Range;

/// What was written as other formats have it, and what to write instead; from the place and the message of the parser.
/// Cost: that of the line.
pub fn syntax_fault(text: &str, span: &Range<usize>, message: &str) -> Option<(String, String)> {
    let start = text.floor_char_boundary(span.start);
    let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
    let line = text[line_start..].lines().next()?.trim();
    if [";", "//", "--"].iter().any(|comment| line.starts_with(comment)) {
        return Some(("a comment begins with `#`".into(), "write `# …`".into()));
    }
    if message == "duplicate key" && line.starts_with('[') && !line.starts_with("[[") {
        let name = line.trim_matches(['[', ']']);
        return Some((
            format!("`[{name}]` stands here for the second time"),
            format!("write it once, with all its keys; what there may be several of is `[[{name}]]` each time"),
        ));
    }
    if let Some(colon) = line.find(':').filter(|&colon| line.find('=').is_none_or(|equals| colon < equals)) {
        let (key, value) = (line[..colon].trim(), line[colon + 1..].trim());
        return Some(("a key and its value are joined by `=`".into(), format!("write `{key} = {value}`")));
    }
    let is_part = |c: char| !matches!(c, ',' | '[' | ']' | '{' | '}' | '#' | '=') && !c.is_whitespace();
    let begin = text[..start]
        .rfind(|c: char| !is_part(c))
        .map_or(0, |at| at + text[at..].chars().next().map_or(1, char::len_utf8));
    let rest = &text[begin..];
    let word = &rest[..rest.find(|c: char| !is_part(c)).unwrap_or(rest.len())];
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    if word.is_empty() || word.contains(['"', '\'']) {
        return None;
    }
    if word.eq_ignore_ascii_case("true") || word.eq_ignore_ascii_case("false") {
        let small = word.to_ascii_lowercase();
        return Some((format!("`{word}` is written in small letters"), format!("write `{small}`")));
    }
    if word.strip_suffix("deg").is_some_and(is_number) {
        return Some(("an angle with its unit is a text".into(), format!("write `\"{word}\"`")));
    }
    if let Some((above, below)) = word.split_once('/')
        && let (Ok(above), Ok(below)) = (above.parse::<f64>(), below.parse::<f64>())
        && below != 0.0
    {
        return Some((
            "a number is written with a point, and not as a fraction".into(),
            format!("write `{}`", above / below),
        ));
    }
    if is_number(word) {
        let next = rest[word.len()..].trim_start_matches([' ', '\t']);
        let is_next = next.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '"');
        return is_next.then(|| ("there is a comma between values in brackets".into(), format!("write `{word},`")));
    }
    let is_word = word.starts_with(char::is_alphabetic) && !word.contains(':');
    let is_value = text[line_start..begin].contains('=');
    (is_word && is_value).then(|| ("a text stands in quotation marks".into(), format!("write `\"{word}\"`")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml::de::DeTable;

    #[test]
    fn what_other_formats_write_is_told_with_what_to_write() {
        for (text, message, help) in [
            ("size = [8.0 6.0]\n", "a comma between values", "write `8.0,`"),
            ("name = dept\n", "in quotation marks", "write `\"dept\"`"),
            ("names = [\"a\", dept]\n", "in quotation marks", "write `\"dept\"`"),
            ("start = [1,1,90deg]\n", "with its unit is a text", "write `\"90deg\"`"),
            ("name: a\n", "joined by `=`", "write `name = a`"),
            ("; hi\n", "begins with `#`", "write `# …`"),
            ("open = True\n", "small letters", "write `true`"),
            ("size = 1/4\n", "not as a fraction", "write `0.25`"),
            ("[wall]\na = 1\n[wall]\nb = 1\n", "for the second time", "`[[wall]]` each time"),
        ] {
            let errors = DeTable::parse_recoverable(text).1;
            let told = syntax_fault(text, &errors[0].span().expect("it has a place"), errors[0].message());
            let (told, advice) = told.expect(text);
            assert!(told.contains(message) && advice.contains(help), "{text}{told}\n{advice}");
        }
        let text = "a = \"x\n";
        let errors = DeTable::parse_recoverable(text).1;
        assert_eq!(syntax_fault(text, &errors[0].span().expect("it has a place"), errors[0].message()), None);
    }
}
