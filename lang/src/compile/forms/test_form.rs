//! `(deftest NAME ["DOC"] [:OPTION VALUE...] FORM...)`: a test of the definitions in its text.

use crate::code::CodeKind;
use crate::compile::compiler::{Compiler, thunk};
use crate::compile::resolved::{TestForm, TestOptions, TopLevel};
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::suggest::suggest;
use crate::syntax::{NodeId, NodeKind};
use std::sync::Arc;

const FORM: &str = "`(deftest NAME [\"DOC\"] [:world \"NAME\"] [:seed N] FORM...)`";
const OPTIONS: [&str; 4] = ["world", "scenario", "seed", "until"];

impl Compiler<'_> {
    /// The test; none if it belongs to a file that is loaded, where it is only checked.
    pub(super) fn define_test(&mut self, rest: &[NodeId], span: Span) -> Option<TopLevel> {
        let Some(name) = rest.first().and_then(|&name| self.tree.symbol(name)) else {
            self.malformed(span, FORM);
            return None;
        };
        let name: Arc<str> = self.symbols.name(name).into();
        let mut body = &rest[1..];
        let mut doc = None;
        if let Some(NodeKind::Str(text)) = body.first().map(|&first| &self.tree.get(first).kind)
            && body.len() > 1
        {
            (doc, body) = (Some(text.clone()), &body[1..]);
        }
        let mut options = TestOptions::default();
        while let [option, value, ..] = body
            && let NodeKind::Keyword(keyword) = self.tree.get(*option).kind
        {
            let keyword = self.symbols.name(keyword).to_string();
            self.test_option(&keyword, *option, *value, &mut options);
            body = &body[2..];
        }
        let function_name = self.symbols.intern("form");
        let (resolved, scope) = self.in_function(CodeKind::Function, true, |compiler| {
            compiler.find_tags(body);
            compiler.body(body, span)
        });
        let function = thunk(function_name, CodeKind::Function, resolved, scope, span);
        if !self.loading.is_empty() {
            return None;
        }
        self.refuse_second_test(&name, span);
        Some(TopLevel::Test(TestForm { name, doc, options, span }, function))
    }

    fn test_option(&mut self, keyword: &str, option: NodeId, value: NodeId, options: &mut TestOptions) {
        let expected = match (keyword, &self.tree.get(value).kind) {
            ("world", NodeKind::Str(world)) => return options.world = Some(world.clone()),
            ("scenario", NodeKind::Str(scenario)) => return options.scenario = Some(scenario.clone()),
            ("seed", &NodeKind::Int(seed @ 0..)) => return options.seed = Some(seed.unsigned_abs()),
            ("until", &NodeKind::Int(until @ 0..)) => return options.until_s = Some(until as f64),
            ("until", &NodeKind::Float(until)) if until >= 0.0 => return options.until_s = Some(until),
            ("world", _) => "a world, such as \"dept\"",
            ("scenario", _) => "a file, such as \"rotated.rpl\"",
            ("seed", _) => "an integer from 0 on",
            ("until", _) => "a time, such as 10min",
            _ => {
                let help = match suggest(keyword, OPTIONS.into_iter()) {
                    Some(meant) => format!("did you mean `:{meant}`?"),
                    None => "the options are :world :scenario :seed :until".to_string(),
                };
                let message = format!("a test has no option `:{keyword}`");
                let finding = Diagnostic::error("test-option", self.tree.span(option), message, "unknown option");
                return self.diagnostics.push(finding.help(help));
            }
        };
        let message = format!("the value of `:{keyword}` is {expected}");
        self.error("test-option", self.tree.span(value), message, format!("expected {expected}"));
    }

    fn refuse_second_test(&mut self, name: &Arc<str>, span: Span) {
        if let Some(first) = self.tests.insert(name.clone(), span) {
            let message = format!("two tests are called `{name}`");
            self.error("test-twice", span, message, "the second").related.push((first, "the first".into()));
        }
    }
}
