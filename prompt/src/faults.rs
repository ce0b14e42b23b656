//! Faults of the program itself, noted instead of written between the lines of the prompt.

use std::any::Any;
use std::panic::{PanicHookInfo, set_hook, take_hook};
use std::sync::{Arc, Mutex};

/// Where the last fault of the program was, for the user; nothing is written of it by itself.
#[derive(Clone, Default)]
pub struct Faults(Arc<Mutex<Option<String>>>);

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

impl Faults {
    /// Notes faults of the present thread from now on, instead of writing them between the lines
    /// of the prompt; what it gives back is to be set when the prompt has ended.
    pub fn catch(&self) -> Arc<Hook> {
        let before: Arc<Hook> = Arc::new(take_hook());
        let (faults, usual) = (self.0.clone(), before.clone());
        let prompt = std::thread::current().id();
        set_hook(Box::new(move |panic| {
            if std::thread::current().id() != prompt {
                return usual(panic);
            }
            let place = panic.location().map_or(String::new(), |place| format!(" ({}:{})", place.file(), place.line()));
            if let Ok(mut last) = faults.lock() {
                *last = Some(format!("{}{place}", message(panic.payload())));
            }
        }));
        before
    }

    /// Writes faults as before.
    pub fn let_go(before: Arc<Hook>) {
        drop(take_hook());
        set_hook(Box::new(move |panic| before(panic)));
    }

    /// Where the last one was, in words.
    pub fn take(&self) -> String {
        let last = self.0.lock().map_or(None, |mut last| last.take());
        last.unwrap_or_else(|| "of an unknown kind".to_string())
    }
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("of an unknown kind")
}
