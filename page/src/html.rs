//! The page as one file: markup, style and modules in one text, so that it needs nothing besides.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

const PAGE: &str = include_str!("../assets/page.html");
const STYLE: &str = include_str!("../assets/page.css");

/// The modules of the page, by the names they import each other by.
const MODULES: [(&str, &str); 12] = [
    ("rpl/run", include_str!("../assets/run.js")),
    ("rpl/nodes", include_str!("../assets/nodes.js")),
    ("rpl/tree", include_str!("../assets/tree.js")),
    ("rpl/compare", include_str!("../assets/compare.js")),
    ("rpl/elements", include_str!("../assets/elements.js")),
    ("rpl/map", include_str!("../assets/map.js")),
    ("rpl/plan", include_str!("../assets/plan.js")),
    ("rpl/tasks", include_str!("../assets/tasks.js")),
    ("rpl/quantities", include_str!("../assets/quantities.js")),
    ("rpl/time", include_str!("../assets/time.js")),
    ("rpl/sources", include_str!("../assets/sources.js")),
    ("rpl/view", include_str!("../assets/view.js")),
];

/// The module that starts the page.
const MAIN: &str = include_str!("../assets/main.js");

/// Where the lines of the page come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// From the server that the page came from.
    Server,
    /// From the page itself: no host is asked for anything.
    Itself,
}

/// The page, with data in it that its modules find.
pub fn page(title: &str, source: Source, data: &str) -> String {
    let imports: Vec<String> = MODULES
        .iter()
        .map(|(name, text)| format!("\"{name}\":\"data:text/javascript;base64,{}\"", STANDARD.encode(text)))
        .collect();
    let connect = match source {
        Source::Server => "'self'",
        Source::Itself => "'none'",
    };
    let parts = [
        ("{{title}}", escaped(title)),
        ("{{connect}}", connect.to_string()),
        ("{{style}}", STYLE.to_string()),
        ("{{imports}}", format!("{{\"imports\":{{{}}}}}", imports.join(","))),
        ("{{main}}", MAIN.to_string()),
        ("{{data}}", data.to_string()),
    ];
    let mut html = String::with_capacity(PAGE.len() + STYLE.len() + MAIN.len() + data.len() + (64 << 10));
    let mut rest = PAGE;
    // In one pass: what a part has in it is not looked at again.
    while let Some(start) = rest.find("{{") {
        let (before, from) = rest.split_at(start);
        html.push_str(before);
        match parts.iter().find(|(name, _)| from.starts_with(name)) {
            Some((name, text)) => {
                html.push_str(text);
                rest = &from[name.len()..];
            }
            None => {
                html.push_str("{{");
                rest = &from[2..];
            }
        }
    }
    html.push_str(rest);
    html
}

/// A text as it stands between tags.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
