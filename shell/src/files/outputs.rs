//! Files and folders that a command writes. They are tried before the work begins, so that no run is
//! in vain; none of them may be what the command has read; and what another run left in a folder of
//! figures does not stay among the new ones.

use crate::files::inputs;
use crate::files::shown::Shown;
use anyhow::{Context, Result, bail};
use rpl_drawing::export;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// What has been opened for writing in this process.
static OPENED: Mutex<Vec<(inputs::Identity, PathBuf)>> = Mutex::new(Vec::new());

/// A file that can be written. What it held stays until then; what was not there before is gone again
/// if nothing is written.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    /// What it is, as errors call it: "the trace".
    what: &'static str,
    file: Option<File>,
    /// The file that was made, behind the link if the path is one.
    made: Option<PathBuf>,
}

impl OutputFile {
    /// Opens a file for what is to be written.
    ///
    /// # Errors
    /// It cannot be written, or the command has read it, or it is to be written twice.
    pub fn open(path: &Path, what: &'static str) -> Result<Self> {
        let shown = path.shown();
        let is_new = !path.exists();
        let opened = File::options().write(true).create(true).truncate(false).open(path);
        let file = opened.map_err(|error| match path.parent() {
            Some(folder) if error.kind() == io::ErrorKind::NotFound && !folder.as_os_str().is_empty() => {
                anyhow::anyhow!("cannot write {what} `{shown}`: there is no folder `{}`", folder.shown())
            }
            _ => anyhow::anyhow!("cannot write {what} `{shown}`: {}", inputs::reason(&error)),
        })?;
        let made = is_new.then(|| path.canonicalize().unwrap_or(path.to_path_buf()));
        let output = Self { path: path.to_path_buf(), what, file: Some(file), made };
        refuse_input(path, what)?;
        if !is_new && path.extension().is_some_and(|extension| extension == "rpl") {
            bail!("{what} cannot go into `{shown}`, which is a plan; name another file");
        }
        if let Some(identity) = inputs::identity(path)
            && let Ok(mut opened) = OPENED.lock()
        {
            if let Some((_, other)) = opened.iter().find(|(known, _)| *known == identity) {
                bail!("{what} cannot go into `{shown}`: `{}` is written already; name another file", other.shown());
            }
            opened.push((identity, path.to_path_buf()));
        }
        Ok(output)
    }

    /// The file, empty, to be written on and on.
    ///
    /// # Errors
    /// It cannot be emptied.
    pub fn begin(self) -> Result<File> {
        let cannot = format!("cannot write {} `{}`", self.what, self.path.shown());
        let file = self.into_file()?;
        // A pipe or a device has no length.
        if file.metadata().is_ok_and(|known| known.is_file()) {
            file.set_len(0).context(cannot)?;
        }
        Ok(file)
    }

    /// The file, with what it held.
    ///
    /// # Errors
    /// It was handed out already.
    pub fn into_file(mut self) -> Result<File> {
        self.file.take().with_context(|| format!("cannot write {} `{}`", self.what, self.path.shown()))
    }

    /// Writes all at once.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(self, bytes: &[u8]) -> Result<()> {
        let cannot = format!("cannot write {} `{}`", self.what, self.path.shown());
        self.begin()?.write_all(bytes).context(cannot)
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if let (Some(_), Some(made)) = (&self.file, &self.made) {
            // It was made only to see whether it can be made.
            fs::remove_file(made).ok();
        }
    }
}

fn refuse_input(path: &Path, what: &str) -> Result<()> {
    match inputs::input_at(path) {
        Some(input) if input == path => {
            bail!("{what} cannot go into `{}`, which this command reads; name another file", path.shown())
        }
        Some(input) => bail!(
            "{what} cannot go into `{}`: it is the file `{}`, which this command reads; name another file",
            path.shown(),
            input.shown()
        ),
        None => Ok(()),
    }
}

/// A folder that can be written, for the figures and tables of one command.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// The last line of each figure says whose it is, and the text of each image.
    mark: String,
    /// Figures an earlier run of the same command has left.
    old: Vec<PathBuf>,
}

impl OutputFolder {
    /// Opens a folder, which is made if it is not there, for what a command draws and writes.
    ///
    /// # Errors
    /// It cannot be made or written.
    pub fn open(path: &Path, command: &str) -> Result<Self> {
        let shown = path.shown();
        fs::create_dir_all(path)
            .map_err(|error| anyhow::anyhow!("cannot make the folder `{shown}`: {}", inputs::reason(&error)))?;
        let trial = path.join(format!(".rpl-{}.trial", std::process::id()));
        File::create_new(&trial)
            .and_then(|_| fs::remove_file(&trial))
            .map_err(|error| anyhow::anyhow!("cannot write into the folder `{shown}`: {}", inputs::reason(&error)))?;
        let mark = format!("<!-- drawn by rpl {command} -->");
        let entries = fs::read_dir(path).with_context(|| format!("cannot read the folder `{shown}`"))?;
        let mut old: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        old.retain(|file| is_drawing(file) && bears(file, &mark));
        Ok(Self { path: path.to_path_buf(), mark, old })
    }

    /// The same, and these are the names of figures that will be drawn there in any case.
    ///
    /// # Errors
    /// As for [`OutputFolder::open`]; or a file of the name is there that the command has not drawn.
    pub fn open_for(path: &Path, command: &str, names: &[&str]) -> Result<Self> {
        let folder = Self::open(path, command)?;
        let paths = names.iter().map(|name| folder.path.join(name));
        paths.flat_map(formats_of).try_for_each(|path| folder.refuse_foreign(&path))?;
        Ok(folder)
    }

    fn refuse_foreign(&self, path: &Path) -> Result<()> {
        if path.exists() && !bears(path, &self.mark) {
            bail!(
                "`{}` was not drawn by this command and is not overwritten; move it, or name another folder",
                path.shown()
            );
        }
        Ok(())
    }

    /// Writes a figure, `name.svg` and beside it `name.png` and `name.pdf`. The first one takes the place of all that an earlier run has
    /// left.
    ///
    /// # Errors
    /// It cannot be written, or something else has its name.
    pub fn draw(&mut self, name: &str, drawing: &str) -> Result<()> {
        for old in std::mem::take(&mut self.old) {
            fs::remove_file(&old).with_context(|| format!("cannot remove the old drawing `{}`", old.shown()))?;
        }
        let paths = formats_of(self.path.join(name));
        paths.iter().try_for_each(|path| self.refuse_foreign(path))?;
        let text = format!("{}\n{}\n", drawing.trim_end(), self.mark);
        let pixels = export::png(drawing, &self.mark).with_context(|| format!("`{name}` cannot become an image"))?;
        let page = export::pdf(drawing, &self.mark).with_context(|| format!("`{name}` cannot become a PDF"))?;
        paths.iter().zip([text.into_bytes(), pixels, page]).try_for_each(|(path, bytes)| {
            fs::write(path, bytes).with_context(|| format!("cannot write the drawing `{}`", path.shown()))
        })
    }

    /// What is no figure, empty, to be written on and on.
    ///
    /// # Errors
    /// It cannot be made, or it is what the command has read.
    pub fn begin(&self, name: &str) -> Result<File> {
        let path = self.path.join(name);
        refuse_input(&path, "a result")?;
        File::create(&path).with_context(|| format!("cannot write `{}`", path.shown()))
    }

    /// What stands there already, to be read.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(&self, name: &str) -> Result<File> {
        let path = self.path.join(name);
        File::open(&path).with_context(|| format!("cannot read `{}` again", path.shown()))
    }

    /// Gives a file the place of another one.
    ///
    /// # Errors
    /// It cannot be moved.
    pub fn replace(&self, new: &str, old: &str) -> Result<()> {
        let (new, old) = (self.path.join(new), self.path.join(old));
        fs::rename(&new, &old).with_context(|| format!("cannot write `{}`", old.shown()))
    }

    /// Writes what is no figure.
    ///
    /// # Errors
    /// It cannot be written, or it is what the command has read.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) -> Result<()> {
        let mut file = self.begin(name)?;
        file.write_all(text.as_ref()).with_context(|| format!("cannot write `{}`", self.path.join(name).shown()))
    }
}

/// Writes a text to a file that is not there yet, or that may be written anew.
///
/// # Errors
/// One clause that says why not; a file that is there is as it was.
pub fn write_new(path: &Path, text: &str, may_overwrite: bool) -> Result<(), String> {
    let mut options = File::options();
    options.write(true);
    match may_overwrite {
        true => options.truncate(true),
        false => options.create_new(true),
    };
    let mut file = options.open(path).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => "it is there already; another name is needed".to_string(),
        io::ErrorKind::NotFound => "there is no such folder".to_string(),
        _ => inputs::reason(&error),
    })?;
    file.write_all(text.as_bytes()).map_err(|error| inputs::reason(&error))
}

/// The files of a figure: SVG, PNG, PDF.
fn formats_of(svg: PathBuf) -> [PathBuf; 3] {
    let (png, pdf) = (svg.with_extension("png"), svg.with_extension("pdf"));
    [svg, png, pdf]
}

fn is_drawing(path: &Path) -> bool {
    path.extension().is_some_and(|extension| ["svg", "png", "pdf"].iter().any(|format| extension == *format))
        && path.is_file()
}

/// The text of an image stands before its pixels.
const IMAGE_HEAD_BYTES: u64 = 1024;

/// The mark stands at the end of a text or a page, before its last line break.
const MARK_TAIL_BYTES: u64 = 256;

/// Whether this mark stands at the beginning of an image, or at the end of any other drawing.
fn bears(path: &Path, mark: &str) -> bool {
    if path.extension().is_some_and(|extension| extension == "png") {
        let mut head = Vec::new();
        let is_read = File::open(path).and_then(|file| file.take(IMAGE_HEAD_BYTES).read_to_end(&mut head)).is_ok();
        return is_read && head.windows(mark.len()).any(|part| part == mark.as_bytes());
    }
    let mut tail = Vec::new();
    let is_read = File::open(path).and_then(|mut file| {
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(MARK_TAIL_BYTES)))?;
        file.take(MARK_TAIL_BYTES).read_to_end(&mut tail)
    });
    is_read.is_ok() && tail.trim_ascii_end().ends_with(mark.as_bytes())
}
