//! Fields of JSON objects by name.
//!
//! *Invariant:* a missing field is null.

use serde_json::Value;

static NULL: Value = Value::Null;

/// Reading and setting of fields.
pub(crate) trait JsonFields {
    /// The value of a field.
    fn at(&self, key: &str) -> &Value;
    /// Sets a field of an object.
    fn set(&mut self, key: &str, value: Value);
}

impl JsonFields for Value {
    fn at(&self, key: &str) -> &Value {
        self.get(key).unwrap_or(&NULL)
    }

    fn set(&mut self, key: &str, value: Value) {
        if let Value::Object(fields) = self {
            fields.insert(key.to_owned(), value);
        }
    }
}
