//! How a study reports its stages.

/// Learns which stages of work a study begins, how far they are and when they end.
pub trait Monitor: Sync {
    /// A stage of this name begins. It ends when the returned value is dropped.
    fn begin<'a>(&'a self, name: &str) -> Box<dyn Stage + 'a>;

    /// Something was assumed that the user has to know: a line.
    fn warn(&self, line: &str);
}

/// A stage of work.
pub trait Stage: Sync {
    /// A part of the work is done, 0 to 1.
    fn reached(&self, part: f64);
}

impl dyn Monitor + '_ {
    /// Does `work` as a stage; `work` reports the part that is done, 0 to 1.
    pub fn during<T>(&self, name: &str, work: impl FnOnce(&(dyn Fn(f64) + Sync)) -> T) -> T {
        let stage = self.begin(name);
        work(&|part| stage.reached(part))
    }
}

/// Keeps nothing of what it learns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Monitor for Silent {
    fn begin<'a>(&'a self, _: &str) -> Box<dyn Stage + 'a> {
        Box::new(Self)
    }

    fn warn(&self, _: &str) {}
}

impl Stage for Silent {
    fn reached(&self, _: f64) {}
}
