//! Serves the page of a run that goes on. A browser that was away, or loads the page anew, asks for what it has not got.
//!
//! | request | answer |
//! | --- | --- |
//! | `GET /` | the page |
//! | `GET /lines?from=N` | the lines behind byte N of the series, with the head if N is 0; as soon as there are some |
//! | `POST /ask` | nothing: what is asked for comes to the driver of the run |
//!
//! Who is on this machine may look. From elsewhere, and to steer, a token is needed, which is part of the link. What another
//! page has a browser send is refused: it does not name this host, or comes from another origin.
//!
//! Anybody can connect, and nobody can keep others from the page, or the run from going on. Run and page share nothing: each
//! hands over what it has to tell and does not wait for the other. One thread serves all connections at once, behind
//! everything else that the machine computes; how many there are, how long each lasts and what is kept of it have limits.
//!
//! Read in this order: [`news`], [`access`], `limits`, `lines`, `answer`, `desk`, `connections`.

pub mod access;
mod answer;
mod connections;
mod desk;
mod limits;
mod lines;
pub mod news;
#[cfg(test)]
mod tests;

use access::Access;
use connections::Connections;
use desk::Desk;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use limits::Limits;
use news::{Asked, News, Trouble};
use std::cell::RefCell;
use std::convert::Infallible;
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use std::os::fd::AsRawFd;
use std::pin::pin;
use std::rc::Rc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel, sync_channel};
use std::thread;
use std::time::Duration;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::runtime::{self, Runtime};
use tokio::task::{LocalSet, spawn_local, yield_now};
use tokio::time::{sleep, timeout};

/// The head of a request is no longer, and no more of an answer is laid out before the system takes it.
const MOST_BUFFERED: usize = 16 << 10;

/// What the system takes of an answer before somebody reads.
const SEND_BUFFER: u32 = 256 << 10;

/// Connections that the system has made and that were not let in yet.
const MOST_UNMET: u32 = 128;

/// How often the news of a run is taken in, also when nobody looks.
const CATCH_UP: Duration = Duration::from_millis(100);

/// After the system has let nobody in, it is asked again this much later.
const RECOVERY: Duration = Duration::from_millis(100);

/// More that was asked for does not wait for the run.
const MOST_ASKED: usize = 64;

/// How much the thread of the page stands behind others: with it on one core, the run loses 4 %.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 14;

/// A server at work; it ends with the process.
#[derive(Debug)]
pub struct Server {
    /// What to open in a browser.
    pub link: String,
    /// Takes what becomes known of the run.
    pub news: Sender<News>,
    /// What is asked for.
    pub asked: Receiver<Asked>,
    troubles: Receiver<Trouble>,
    has_ended: bool,
}

impl Server {
    /// Serves a page at an address, and the run that it asks for, whose series has this head.
    ///
    /// # Errors
    /// The address is taken, or is none of this machine.
    pub fn start(address: SocketAddr, access: Access, page: String, head: String) -> io::Result<Self> {
        Self::start_within(Limits::of_process(), address, access, page, head)
    }

    fn start_within(
        limits: Limits,
        address: SocketAddr,
        access: Access,
        page: String,
        head: String,
    ) -> io::Result<Self> {
        let runtime = runtime::Builder::new_current_thread().enable_io().enable_time().build()?;
        let listener = listen(&runtime, address)?;
        let address = listener.local_addr()?;
        let token = access.token.as_ref().map_or(String::new(), |token| format!("?token={token}"));
        let link = format!("http://{address}/{token}");
        let (news, heard) = channel();
        let (asking, asked) = sync_channel(MOST_ASKED);
        let (telling, troubles) = channel();
        thread::Builder::new().name("page".into()).spawn(move || {
            stand_behind();
            let desk = Desk::new((page, head), (access, address), &limits, heard, asking);
            let connections = RefCell::new(Connections::new(limits.connections));
            LocalSet::new().block_on(&runtime, Rc::new(Service { limits, desk, connections }).serve(listener, telling))
        })?;
        Ok(Self { link, news, asked, troubles, has_ended: false })
    }

    /// Why the page does not answer, if that was not told before.
    pub fn trouble(&mut self) -> Option<Trouble> {
        match self.troubles.try_recv() {
            Ok(trouble) => Some(trouble),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                let is_told = std::mem::replace(&mut self.has_ended, true);
                (!is_told).then_some(Trouble::Ended)
            }
        }
    }
}

/// Whatever else the machine computes goes first.
fn stand_behind() {
    // Elsewhere this would be said of the whole process. Where it cannot be said, the page is served all the same.
    #[cfg(target_os = "linux")]
    rustix::process::setpriority_process(None, NICENESS).ok();
}

/// A listener at an address, for this runtime.
fn listen(runtime: &Runtime, address: SocketAddr) -> io::Result<TcpListener> {
    let _within = runtime.enter();
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // A port is free again as soon as the server before has ended.
    socket.set_reuseaddr(true)?;
    // Without a size, the system keeps megabytes for everybody who does not read. Connections have what their listener has.
    socket.set_send_buffer_size(SEND_BUFFER)?;
    socket.bind(address)?;
    socket.listen(MOST_UNMET)
}

/// What serves everybody.
struct Service {
    limits: Limits,
    desk: Desk,
    connections: RefCell<Connections>,
}

impl Service {
    /// Lets in who comes, for good.
    async fn serve(self: Rc<Self>, listener: TcpListener, troubles: Sender<Trouble>) -> Infallible {
        let service = self.clone();
        spawn_local(async move {
            loop {
                service.desk.catch_up();
                sleep(CATCH_UP).await;
            }
        });
        let mut is_told = false;
        loop {
            let trouble = match listener.accept().await {
                Ok((stream, _)) if stream.as_raw_fd() as u64 >= self.limits.first_of_run => {
                    Trouble::FewFiles { most: self.limits.files }
                }
                Ok((stream, from)) => {
                    self.welcome(stream, from);
                    while self.connections.borrow().is_crowded() {
                        yield_now().await;
                    }
                    continue;
                }
                // Whoever came has gone already.
                Err(error) if error.kind() == ErrorKind::ConnectionAborted => continue,
                Err(error) => Trouble::CannotAccept(error),
            };
            if !is_told {
                is_told = true;
                // A run that has ended hears nothing.
                troubles.send(trouble).ok();
            }
            sleep(RECOVERY).await;
        }
    }

    fn welcome(self: &Rc<Self>, stream: TcpStream, from: SocketAddr) {
        let mut connections = self.connections.borrow_mut();
        let place = Place { service: self.clone(), number: connections.next() };
        let task = spawn_local(place.converse(stream));
        connections.add(from.ip(), task.abort_handle());
    }
}

/// The place of somebody who is connected; free when it is dropped.
struct Place {
    service: Rc<Service>,
    number: u64,
}

impl Place {
    /// Answers one request after the other for a while.
    async fn converse(self, stream: TcpStream) {
        // What is left of an answer is sent at once; where that cannot be had, a little later.
        stream.set_nodelay(true).ok();
        let Service { limits, desk, connections } = &*self.service;
        let answer = service_fn(|request: Request<Incoming>| async move {
            Ok::<_, Infallible>(match desk.refusal(&request) {
                Some(refusal) => refusal,
                None => {
                    connections.borrow_mut().may_look(self.number);
                    desk.answer(request).await
                }
            })
        });
        let mut http = http1::Builder::new();
        http.timer(TokioTimer::new()).header_read_timeout(limits.head).max_buf_size(MOST_BUFFERED);
        let mut connection = pin!(http.serve_connection(TokioIo::new(stream), answer));
        if timeout(limits.requests, connection.as_mut()).await.is_err() {
            connection.as_mut().graceful_shutdown();
            // Whoever has not taken the answer by then will not take it.
            timeout(limits.last_answer, connection).await.ok();
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.service.connections.borrow_mut().closed(self.number);
    }
}
