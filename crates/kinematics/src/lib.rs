//! truepose-kinematics
