"""How complete the lists of `equilibria` are, judged by a search that shares nothing with them."""
