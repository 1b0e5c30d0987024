"""The program measured against real loops, in public: what it and simple curves get wrong."""
