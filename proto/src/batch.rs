//! The one message that is not generated: a batch of events that may already be in its wire encoding.
//!
//! A server reads batches from the log as bytes and sends them as they are; a client gets decoded events.
//! Invariant: `raw`, when not empty, is a complete encoding of `counterpoint.v1.EventBatch` and is sent alone.

use bytes::{Buf, BufMut, Bytes};
use prost::encoding::{DecodeContext, WireType};
use prost::{DecodeError, Message};

use crate::v1::Event;

/// `counterpoint.v1.EventBatch`.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct EventBatch {
    /// Sequence number covered first; the log counts from 1.
    pub first_seq: u64,
    /// Sequence number covered last: the cursor behind this batch.
    pub last_seq: u64,
    /// The events, ascending by number.
    pub events: Vec<Event>,
    /// Wire encoding of the whole message, sent in place of the fields above; never set by decoding.
    pub raw: Bytes,
}

impl EventBatch {
    /// A batch that is already encoded.
    #[must_use]
    pub fn encoded(raw: Bytes) -> Self {
        Self { raw, ..Self::default() }
    }
}

impl Message for EventBatch {
    fn encode_raw(&self, buf: &mut impl BufMut) {
        if !self.raw.is_empty() {
            buf.put_slice(&self.raw);
            return;
        }
        if self.first_seq != 0 {
            prost::encoding::uint64::encode(1, &self.first_seq, buf);
        }
        if self.last_seq != 0 {
            prost::encoding::uint64::encode(2, &self.last_seq, buf);
        }
        prost::encoding::message::encode_repeated(3, &self.events, buf);
    }

    fn merge_field(
        &mut self,
        tag: u32,
        wire_type: WireType,
        buf: &mut impl Buf,
        ctx: DecodeContext,
    ) -> Result<(), DecodeError> {
        match tag {
            1 => prost::encoding::uint64::merge(wire_type, &mut self.first_seq, buf, ctx),
            2 => prost::encoding::uint64::merge(wire_type, &mut self.last_seq, buf, ctx),
            3 => prost::encoding::message::merge_repeated(wire_type, &mut self.events, buf, ctx),
            _ => prost::encoding::skip_field(wire_type, tag, buf, ctx),
        }
    }

    fn encoded_len(&self) -> usize {
        if !self.raw.is_empty() {
            return self.raw.len();
        }
        let number = |tag, value: u64| if value == 0 { 0 } else { prost::encoding::uint64::encoded_len(tag, &value) };
        number(1, self.first_seq)
            + number(2, self.last_seq)
            + prost::encoding::message::encoded_len_repeated(3, &self.events)
    }

    fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoded_and_plain_batches_are_the_same_on_the_wire() {
        let event = |seq| Event { seq, line: 7, ..Event::default() };
        let plain = EventBatch { first_seq: 3, last_seq: 4, events: vec![event(3), event(4)], raw: Bytes::new() };
        let wire = plain.encode_to_vec();
        let raw = EventBatch::encoded(Bytes::from(wire.clone()));
        assert_eq!(raw.encode_to_vec(), wire);
        assert_eq!(raw.encoded_len(), wire.len());
        assert_eq!(EventBatch::decode(wire.as_slice()).unwrap(), plain);
    }
}
