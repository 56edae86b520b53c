//! A log's messages in a queue: all threads track the images that wait in it, and all messages leave it in their order.
//!
//! The thread that reads the log tracks images as well while the queue is full: none waits for another, and there is none too many.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};

use logs::read::RawMessage;
use logs::write::Received;
use rayon::{ScopeFifo, Yield};

use crate::frame::{TrackedFrame, track_frame};
use crate::learned::Learned;
use crate::message::is_video;
use crate::size::MOST_WAITING;
use crate::{Decoder, Tracker};

/// Messages and images that wait at the most: enough for the threads, and little memory.
const MOST_MESSAGES: usize = 4096;
const MOST_IMAGES: usize = 32;
/// Bytes that the pixels of these images take at the most, unless one takes more.
const MOST_PIXEL_BYTES: usize = 44 << 20;

/// Tracks images, each by itself, on any thread.
pub(crate) struct FrameTracker<'a> {
    tracker: &'a Tracker,
    learned: &'a Learned,
    is_drawn: bool,
    /// Decoders that no thread uses now; each keeps its memory from image to image.
    decoders: Mutex<Vec<Decoder>>,
}

impl<'a> FrameTracker<'a> {
    pub(crate) fn new(tracker: &'a Tracker, learned: &'a Learned, is_drawn: bool) -> Self {
        Self {
            tracker,
            learned,
            is_drawn,
            decoders: Mutex::default(),
        }
    }

    fn track(&self, decoder: &mut Decoder, image: &RawMessage<'_>) -> TrackedFrame {
        let message = (image.log_time, image.data);
        track_frame(
            (self.tracker, self.learned),
            decoder,
            image.channel,
            message,
            self.is_drawn,
        )
    }

    fn track_by_itself(&self, image: &RawMessage<'_>) -> TrackedFrame {
        let decoders = || self.decoders.lock().unwrap_or_else(PoisonError::into_inner);
        let mut decoder = decoders().pop().unwrap_or_default();
        let frame = self.track(&mut decoder, image);
        decoders().push(decoder);
        frame
    }
}

/// A message that leaves the queue.
pub(crate) enum Processed {
    Message(Received),
    /// An image's log time (ns) and what was found in it.
    Frame(u64, Box<TrackedFrame>),
}

enum Queued {
    Ready(Processed),
    /// An image's log time, and where its frame will come from.
    Image(u64, Receiver<Box<TrackedFrame>>),
}

pub(crate) struct MessageQueue<'s, 'scope> {
    scope: &'s ScopeFifo<'scope>,
    frames: &'scope FrameTracker<'scope>,
    /// Decoder of a video, whose images build on one another.
    decoder: Decoder,
    /// Messages that wait, each with its size in bytes.
    queued: VecDeque<(Queued, usize)>,
    bytes: usize,
    images: usize,
    /// Images that may wait: one, until it is known how large they are.
    most_images: usize,
}

impl<'s, 'scope> MessageQueue<'s, 'scope> {
    pub(crate) fn new(scope: &'s ScopeFifo<'scope>, frames: &'scope FrameTracker<'scope>) -> Self {
        Self {
            scope,
            frames,
            decoder: Decoder::default(),
            queued: VecDeque::new(),
            bytes: 0,
            images: 0,
            most_images: 1,
        }
    }

    pub(crate) fn add_message(&mut self, message: Received) {
        let bytes = message.data.len();
        self.bytes += bytes;
        self.queued
            .push_back((Queued::Ready(Processed::Message(message)), bytes));
    }

    /// Images of a video are tracked in their order, others side by side; one that is larger than what may wait is tracked where it stands.
    pub(crate) fn add_image(&mut self, image: &RawMessage<'_>) {
        let (log_time, frames) = (image.log_time, self.frames);
        let is_video = is_video(&image.channel.schema);
        let (message, bytes) = if is_video || image.data.len() > MOST_WAITING {
            let frame = if is_video {
                frames.track(&mut self.decoder, image)
            } else {
                frames.track_by_itself(image)
            };
            (
                Queued::Ready(Processed::Frame(log_time, Box::new(frame))),
                0,
            )
        } else {
            let (done, frame) = sync_channel(1);
            let (channel, data) = (Arc::clone(image.channel), image.data.to_vec());
            self.scope.spawn_fifo(move |_| {
                let image = RawMessage {
                    channel: &channel,
                    log_time,
                    data: &data,
                };
                // Nobody waits for it where reading the log has failed.
                drop(done.send(Box::new(frames.track_by_itself(&image))));
            });
            (Queued::Image(log_time, frame), image.data.len())
        };
        self.bytes += bytes;
        self.images += 1;
        self.queued.push_back((message, bytes));
    }

    /// The first message, where the queue is full.
    pub(crate) fn next_if_full(&mut self) -> Option<Processed> {
        let is_full = self.bytes > MOST_WAITING
            || self.queued.len() > MOST_MESSAGES
            || self.images >= self.most_images;
        if is_full { self.next() } else { None }
    }

    /// The first message; none where the queue is empty.
    pub(crate) fn next(&mut self) -> Option<Processed> {
        let (message, bytes) = self.queued.pop_front()?;
        self.bytes -= bytes;
        if !matches!(message, Queued::Ready(Processed::Message(_))) {
            self.images -= 1;
        }
        match message {
            Queued::Ready(processed) => Some(processed),
            Queued::Image(log_time, frame) => match wait(&frame) {
                Some(frame) => {
                    if let Some([width, height]) = frame.size {
                        let most = MOST_PIXEL_BYTES / (3 * width * height);
                        self.most_images = most.clamp(1, MOST_IMAGES);
                    }
                    Some(Processed::Frame(log_time, frame))
                }
                // The thread that tracked it panicked, and so does the scope at its end.
                None => self.next(),
            },
        }
    }
}

/// Waits for a frame, and tracks others as long as there are any.
fn wait(frame: &Receiver<Box<TrackedFrame>>) -> Option<Box<TrackedFrame>> {
    loop {
        match frame.try_recv() {
            Ok(frame) => return Some(frame),
            Err(TryRecvError::Disconnected) => return None,
            Err(TryRecvError::Empty) => {
                if rayon::yield_now() != Some(Yield::Executed) {
                    return frame.recv().ok();
                }
            }
        }
    }
}
