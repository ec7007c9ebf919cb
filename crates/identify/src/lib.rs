//! truepose-identify
