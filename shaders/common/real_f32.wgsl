// The float that a probe computes with.
alias real = f32;

