//! truepose-io
